// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/UnusedVertices.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/Tuples.h"
#include "filters/outofcore/mesh/ExternalUnused.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

std::vector<std::byte> TuplesOf(const Mesh& mesh)
{
  std::vector<const Attribute*> arrays;
  for (const Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      arrays.push_back(&array);
    }
  }
  return InterleaveTuples(arrays, mesh.points.size());
}

VertexFiles FilesOf(SpillFolder& folder, const Mesh& mesh)
{
  VertexFiles files;
  files.count = static_cast<std::uint32_t>(mesh.points.size());
  files.points = Spilled(folder, mesh.points);
  const std::vector<std::byte> tuples = TuplesOf(mesh);
  files.tupleBytes = tuples.size() / mesh.points.size();
  if (!tuples.empty())
  {
    files.tuples = Spilled(folder, tuples);
  }
  return files;
}

void ExpectVertices(const VertexFiles& files, const Mesh& expected)
{
  ASSERT_EQ(files.count, expected.points.size());
  EXPECT_EQ(ReadBack<Vec3>(files.points), expected.points);
  if (files.tupleBytes > 0)
  {
    EXPECT_EQ(ReadBack<std::byte>(files.tuples), TuplesOf(expected));
  }
}

}

TEST(ExternalUnused, AsInMemory)
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "attributes", WithAttributes(Shuffled(DisplacedSphere(3), 2), 5) });
  meshes.back().mesh.triangles.resize(100);
  for (const NamedMesh& named : meshes)
  {
    if (named.mesh.triangles.empty())
    {
      continue;
    }
    Mesh used = named.mesh;
    const Mesh unused = TakeUnusedVertices(used, FindUsedVertices(named.mesh));
    for (const std::uint64_t memory : { 8, 200, 1 << 20 }) // many sections of marks, and one
    {
      SCOPED_TRACE(named.name + ", memory " + std::to_string(memory));
      if (memory == 8 && named.mesh.points.size() > 3000)
      {
        continue; // it would take too long
      }
      SpillFolder folder = MakeSpillFolder();
      std::vector<NumberedTriangle> triangles;
      for (const Triangle& corners : named.mesh.triangles)
      {
        triangles.push_back({ corners, static_cast<std::uint32_t>(triangles.size()) });
      }
      const SpillFile file = Spilled(folder, triangles);
      const Result<PartedVertices> parted =
        PartUnusedExternally(folder, FilesOf(folder, named.mesh), file, triangles.size(), memory);
      ASSERT_TRUE(parted) << parted.GetError().message;
      ExpectVertices(parted->used, used);
      ASSERT_EQ(parted->map.has_value(), !unused.points.empty());
      if (!parted->map)
      {
        continue;
      }
      ExpectVertices(parted->unused, unused);
      const std::vector<VertexId> map = ReadBack<VertexId>(parted->map->file);
      for (std::size_t t = 0; t < triangles.size(); ++t)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          ASSERT_EQ(map[triangles[t].corners[k]], used.triangles[t][k]);
        }
      }
    }
  }
}
