// SPDX-License-Identifier: BSD-3-Clause
// Reads a file in chunks of any sizes, as callers of a reader do.
#pragma once

#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/Testing/RandomGenerator.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <string>

namespace kdstream::test
{

inline constexpr std::size_t everything = std::numeric_limits<std::size_t>::max();

struct Contents
{
  MeshFileInfo info;
  Mesh mesh;
  std::uint64_t faces = 0;
  Status status;
};

// Removes the colour array that the reader adds to those of the file (ShownColors.h).
inline void DropShownColors(Contents& contents)
{
  if (("\n" + contents.info.tolerance.ToLines()).find("\nreading ") != std::string::npos)
  {
    contents.info.attributes.pop_back();
    contents.mesh.attributes.pop_back();
  }
}

// Reads a whole file, asking for nextLimit() records at a time.
inline Contents ReadAll(
  const std::filesystem::path& file, const std::function<std::size_t()>& nextLimit)
{
  Contents contents;
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  if (!reader)
  {
    contents.status = reader.GetError();
    return contents;
  }
  contents.info = (*reader)->Info();
  EXPECT_LE((*reader)->FileSize(), std::filesystem::file_size(file)); // padding does not count
  for (const bool vertices : { true, false })
  {
    for (;;)
    {
      const std::size_t limit = nextLimit();
      const std::size_t before = contents.mesh.points.size();
      const Result<std::size_t> read = vertices ? (*reader)->ReadVertices(contents.mesh, limit)
                                                : (*reader)->ReadTriangles(contents.mesh, limit);
      if (!read)
      {
        contents.status = read.GetError();
        const Result<std::size_t> again = (*reader)->ReadTriangles(contents.mesh, limit);
        EXPECT_FALSE(again) << "an error stays";
        EXPECT_TRUE(again || again.GetError().message == read.GetError().message);
        return contents;
      }
      EXPECT_LE(*read, limit);
      EXPECT_LE((*reader)->Position(), (*reader)->FileSize());
      EXPECT_TRUE(!vertices || contents.mesh.points.size() <= before + *read);
      contents.info.tolerance = (*reader)->Info().tolerance;
      contents.faces += vertices ? 0 : *read;
      if (*read == 0)
      {
        break;
      }
    }
  }
  contents.info = (*reader)->Info(); // by now it is known what was ignored at the end
  EXPECT_LE(contents.mesh.triangles.size(), contents.info.mostTriangles);
  return contents;
}

// Compares bits, not values: -0 and 0 differ.
inline bool SameBits(const std::vector<Vec3>& a, const std::vector<Vec3>& b)
{
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}

// Reads a random file of the maker in chunks of up to `mostLimit` records, and expects what the
// file holds. size: passed to Maker::Make.
template <class Maker>
void ExpectReadBack(
  const std::string& name, unsigned seed, std::uint64_t size, std::uint64_t mostLimit)
{
  SCOPED_TRACE("seed " + std::to_string(seed));
  Maker maker(seed);
  RandomGenerator& generator = maker.Generator();
  const RandomFile file = maker.Make(size);
  const fixtures::TemporaryFolder folder;
  Contents read = ReadAll(folder.Write(name, file.bytes),
    [&] { return generator.Chance(0.2) ? everything : 1 + generator.Pick(mostLimit); });
  ASSERT_TRUE(read.status) << read.status.GetError().message;
  DropShownColors(read);
  EXPECT_EQ(read.info.soup, file.soup);
  EXPECT_EQ(read.info.vertices, file.points.size());
  EXPECT_EQ(read.info.faces, file.faces);
  EXPECT_EQ(read.faces, file.faces);
  EXPECT_EQ(read.info.scalarType, file.scalarType);
  EXPECT_EQ(read.mesh.scalarType, file.scalarType);
  EXPECT_EQ(read.info.ignoredAttributes, file.ignored);
  EXPECT_TRUE(SameBits(read.mesh.points, file.points));
  EXPECT_EQ(read.mesh.triangles, file.triangles);
  EXPECT_TRUE(read.mesh.attributes == file.attributes);
  std::vector<AttributeInfo> expected;
  for (const Attribute& attribute : file.attributes)
  {
    expected.push_back(attribute.Info());
  }
  EXPECT_EQ(read.info.attributes, expected);
  EXPECT_EQ(folder.Names().size(), 1U);
}

}
