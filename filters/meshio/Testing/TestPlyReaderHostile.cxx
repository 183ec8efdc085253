// SPDX-License-Identifier: BSD-3-Clause
// PlyReader on damaged files: thousands of seeded mutations of good ones. It must not crash, must
// keep its promises if it accepts a file, and must never allocate memory for data that the file
// does not have: every allocation is counted.
#include "filters/meshio/Testing/CountedMemory.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/ReadHostile.h"
#include "filters/meshio/Testing/SurviveMutations.h"
#include "filters/meshio/ply/PlyReader.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

// Returns true if the file is a mesh. The memory limit covers: the block (at most the file); a
// header's names; triangles of 12 bytes, from indices of one byte, in a vector that doubles; and
// the memory for cutting a polygon.
bool ReadWithinMemory(std::string_view bytes, std::size_t limit)
{
  return ReadCounted([](ByteSource source) { return PlyReader::Open(std::move(source)); }, bytes,
    limit, std::size_t{ 16 } * 1024 + 300 * bytes.size());
}

const std::vector<std::string> lines{ "element vertex 4294967294\n",
  "element face 18446744073709551615\n", "property list uint uint vertex_indices\n",
  "property list int char vertex_index\n", "property double x\n", "property list uchar double y\n",
  "element void 18446744073709551615\n", "property float nx\n", "property uchar red\n",
  "property double wide_0\n", "property uint id_int64_0\nproperty uint id_int64_1\n",
  "property int64 x\n", "property list float double vertex_indexes\n", "element Face 3\n",
  "comment TextureFile a\n", "element tristrips 3\n", "end_header\n",
  "format binary_big_endian 1.0\n", "comment\n" };

}

TEST(PlyReaderHostile, TakesNoMemoryForWhatAHeaderClaims)
{
  const std::string xyz = "property uchar x\nproperty uchar y\nproperty uchar z\n";
  for (const std::string format : { "ascii", "binary_little_endian", "binary_big_endian" })
  {
    for (const std::string count : { "4294967294", "9223372036854775808", "18446744073709551615" })
    {
      const std::string start = "ply\nformat " + format + " 1.0\n";
      const std::string faces =
        "element face " + count + "\nproperty list uint int vertex_indices\n";
      EXPECT_FALSE(ReadWithinMemory(
        start + "element vertex " + count + "\n" + xyz + "end_header\n1 2 3 ", SIZE_MAX));
      EXPECT_FALSE(ReadWithinMemory(
        start + "element vertex 1\n" + xyz + faces + "end_header\n1 2 3\n", SIZE_MAX));
      EXPECT_FALSE(ReadWithinMemory(
        start + faces + "element vertex 1\n" + xyz + "end_header\n1 2 3\n", SIZE_MAX));
      EXPECT_TRUE(ReadWithinMemory(
        start + "element void " + count + "\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n",
        SIZE_MAX));
    }
  }
}

TEST(PlyReaderHostile, SurvivesMutatedFiles)
{
  SurviveMutations<RandomPlyMaker>(ReadWithinMemory, lines, 450, 40);
}

}
