// SPDX-License-Identifier: BSD-3-Clause
// The OFF reader on damaged files: seeded mutations of good ones. It must not crash, must keep its
// promises if it accepts a file, and must never allocate memory for data that the file does not
// have.
#include "filters/meshio/Testing/CountedMemory.h"
#include "filters/meshio/Testing/RandomOff.h"
#include "filters/meshio/Testing/ReadHostile.h"
#include "filters/meshio/Testing/SurviveMutations.h"
#include "filters/meshio/ply/OffHeader.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

// Returns true if the file is a mesh. The memory limit for reading, all at once, is that of PLY.
bool ReadWithinMemory(std::string_view bytes, std::size_t limit)
{
  return ReadCounted([](ByteSource source) { return OpenOffReader(std::move(source), {}, {}); },
    bytes, limit, std::size_t{ 64 } * 1024 + 300 * bytes.size());
}

const std::vector<std::string> lines{ "1 2 3\n", "3 0 1 2\n", "3 0 1 2 255 0 0\n", "4\n0 1 2 0\n",
  "1 2 3 0 0 1 1 0 0\n", "# \n", "4294967295 1 2 3\n", "2 0 1\n", "COFF\n", "0\n", "\n" };

}

TEST(OffReaderHostile, TakesNoMemoryForWhatAHeaderClaims)
{
  for (const std::string count : { "4294967294", "9223372036854775808", "18446744073709551615" })
  {
    EXPECT_FALSE(ReadWithinMemory("OFF\n" + count + " 0 0\n1 2 3\n", SIZE_MAX));
    EXPECT_FALSE(ReadWithinMemory("OFF\n1 " + count + " 0\n1 2 3\n3 0 0 0\n", SIZE_MAX));
    EXPECT_FALSE(ReadWithinMemory("OFF\n1 1 0\n1 2 3\n" + count + " 0 0 0\n", SIZE_MAX));
  }
  EXPECT_FALSE(ReadWithinMemory("OFF\n1 0 0\n1 2 " + std::string(1000000, '3'), SIZE_MAX));
}

TEST(OffReaderHostile, SurvivesMutatedFiles)
{
  SurviveMutations<RandomOffMaker>(ReadWithinMemory, lines);
}

}
