// SPDX-License-Identifier: BSD-3-Clause
// PlyReader on damaged files: thousands of seeded mutations of good ones. It must not crash, must
// keep its promises if it accepts a file, and must never allocate memory for data that the file
// does not have: every allocation is counted.
#include "filters/meshio/Testing/CountedMemory.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/ReadHostile.h"
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

const std::vector<std::string> numbers{ "0", "-1", "1", "255", "256", "65536", "2147483648",
  "4294967294", "4294967295", "4294967296", "9223372036854775807", "9223372036854775808",
  "18446744073709551615", "1e999", "nan" };
const std::vector<std::string> lines{ "element vertex 4294967294\n",
  "element face 18446744073709551615\n", "property list uint uint vertex_indices\n",
  "property list int char vertex_index\n", "property double x\n", "property list uchar double y\n",
  "element void 18446744073709551615\n", "property float nx\n", "property uchar red\n",
  "property double wide_0\n", "property uint id_int64_0\nproperty uint id_int64_1\n",
  "property int64 x\n", "property list float double vertex_indexes\n", "element Face 3\n",
  "comment TextureFile a\n", "element tristrips 3\n", "end_header\n",
  "format binary_big_endian 1.0\n", "comment\n" };

void Mutate(std::string& bytes, RandomPlyMaker& maker)
{
  const std::size_t at = maker.Pick(bytes.size());
  switch (maker.Pick(8))
  {
    case 0: // change one bit
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << maker.Pick(8)));
      break;
    case 1: // change one byte
      bytes[at] = static_cast<char>(maker.Pick(256));
      break;
    case 2: // cut off the end
      bytes.resize(at + 1);
      break;
    case 3: // remove a part
      bytes.erase(at, 1 + maker.Pick(16));
      break;
    case 4: // repeat a part
      bytes.insert(maker.Pick(bytes.size()), bytes.substr(at, 1 + maker.Pick(64)));
      break;
    case 5: // set four bytes to ones
      bytes.replace(at, 4, "\xff\xff\xff\xff");
      break;
    case 6: // change a number of the text
    {
      const std::size_t digit = std::min(bytes.find_first_of("0123456789", at), bytes.size());
      const std::size_t end = std::min(bytes.find_first_not_of("0123456789", digit), bytes.size());
      bytes.replace(digit, end - digit, maker.PickOf(numbers));
      break;
    }
    default: // add a line to the header
      bytes.insert(std::min(bytes.find('\n', at / 4) + 1, bytes.size()), maker.PickOf(lines));
  }
}

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
  int accepted = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 300; ++seed)
  {
    RandomPlyMaker maker(seed);
    const std::string good = maker.Make(1 + maker.Pick(40)).bytes;
    ASSERT_TRUE(ReadWithinMemory(good, SIZE_MAX)) << "seed " << seed;
    for (int round = 0; round < 150; ++round)
    {
      std::string bytes = good;
      for (std::uint64_t count = 1 + maker.Pick(4); count > 0 && !bytes.empty(); --count)
      {
        Mutate(bytes, maker);
      }
      const bool whole = ReadWithinMemory(bytes, SIZE_MAX);
      ASSERT_EQ(whole, ReadWithinMemory(bytes, 1 + maker.Pick(5)))
        << "seed " << seed << ", round " << round;
      ++(whole ? accepted : refused);
    }
  }
  EXPECT_GT(accepted, 1000) << "too few mutants are meshes: the promises were not tested";
  EXPECT_GT(refused, 1000) << "too few mutants are refused: the errors were not tested";
}

}
