// SPDX-License-Identifier: BSD-3-Clause
// The OBJ reader on damaged files: seeded mutations of good ones. It must not crash, must keep its
// promises if it accepts a file, and must never allocate memory for data that the file does not
// have.
#include "filters/meshio/ObjReader.h"
#include "filters/meshio/Testing/CountedMemory.h"
#include "filters/meshio/Testing/RandomObj.h"
#include "filters/meshio/Testing/ReadHostile.h"
#include "filters/meshio/Testing/SurviveMutations.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

// Returns true if the file is a mesh. The memory limit covers: the block (at most the file); the
// tables of files that name normals (their caches grow by blocks of 4 KiB); triangles of 12 bytes,
// from corners of two bytes, in a vector that doubles; and the memory for cutting a polygon.
bool ReadWithinMemory(std::string_view bytes, std::size_t limit)
{
  return ReadCounted([](ByteSource source) { return OpenObjReader(std::move(source), {}, {}); },
    bytes, limit, std::size_t{ 112 } * 1024 + 220 * bytes.size());
}

const std::vector<std::string> lines{ "v 1 2 3\n", "v 1 2 3 4 5 6\n", "f 1 2 3\n", "f -1 -2 -3\n",
  "f 1/1/1 2/2/2 1/2/1\n", "vn 0 0 1\n", "vt 0 0\n", "f 1 \\\n", "# \\\n", "f 4294967295 1 1\n" };

}

TEST(ObjReaderHostile, TakesNoMemoryForIndices)
{
  EXPECT_FALSE(ReadWithinMemory("v 1 2 3\nf 4294967294 1 1\n", SIZE_MAX));
  EXPECT_TRUE(ReadWithinMemory("v 1 2 3\nvn 1 0 0\nf 1//4294967294 1//1 1//1\n", SIZE_MAX));
  EXPECT_FALSE(ReadWithinMemory("f 1 2 3\n" + std::string(3000000, 'x'), SIZE_MAX));
  EXPECT_FALSE(ReadWithinMemory("v 1 2 " + std::string(1000000, '3') + "\nf 1 1 1", SIZE_MAX));
}

TEST(ObjReaderHostile, SurvivesMutatedFiles)
{
  SurviveMutations<RandomObjMaker>(ReadWithinMemory, lines);
}

}
