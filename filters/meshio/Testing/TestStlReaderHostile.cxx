// SPDX-License-Identifier: BSD-3-Clause
// The STL reader on damaged files: seeded mutations of good ones. It must not crash, must keep its
// promises if it accepts a file, and must never allocate memory for data that the file does not
// have.
#include "filters/meshio/StlReader.h"
#include "filters/meshio/Testing/CountedMemory.h"
#include "filters/meshio/Testing/RandomStl.h"
#include "filters/meshio/Testing/ReadHostile.h"
#include "filters/meshio/Testing/SurviveMutations.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

// Returns true if the file is a mesh. The memory limit covers: the block (at most the file), the
// binary reader's batch, and points of 24 bytes, from text of six bytes, in a vector that doubles.
bool ReadWithinMemory(std::string_view bytes, std::size_t limit)
{
  return ReadCounted([](ByteSource source) { return OpenStlReader(std::move(source), {}); }, bytes,
    limit, std::size_t{ 96 } * 1024 + 20 * bytes.size());
}

const std::vector<std::string> lines{ "vertex 1 2 3\n", "endloop\nendfacet\n", "endsolid\n",
  "solid\n", "facet normal 0 0 0\nouter loop\n", "endfacet\n" };

}

TEST(StlReaderHostile, TakesNoMemoryForWhatAHeaderClaims)
{
  EXPECT_FALSE(ReadWithinMemory(std::string(80, '\0') + "\xff\xff\xff\xff", SIZE_MAX));
  EXPECT_FALSE(ReadWithinMemory(std::string(80, '\0') + "\xff\xff\xff\x7f" + "more", SIZE_MAX));
  EXPECT_TRUE(ReadWithinMemory("solid " + std::string(100000, 'n') + "\nendsolid", SIZE_MAX));
  EXPECT_FALSE(ReadWithinMemory("solid \n" + std::string(100000, 'n') + "\nendsolid", SIZE_MAX));
}

TEST(StlReaderHostile, SurvivesMutatedFiles)
{
  SurviveMutations<RandomStlMaker>(ReadWithinMemory, lines);
}

}
