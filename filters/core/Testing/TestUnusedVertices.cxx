// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/UnusedVertices.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

Attribute Numbers(AttributeAssociation association, std::vector<std::uint8_t> values)
{
  Attribute array;
  array.name = "numbers";
  array.type = AttributeType::UInt8;
  array.association = association;
  array.components = 1;
  array.values = std::move(values);
  return array;
}

}

TEST(UnusedVertices, AreTakenOutInTheirOrderWithTheirTuples)
{
  Mesh mesh;
  for (int v = 0; v < 6; ++v)
  {
    mesh.points.push_back({ double(v), 0, 0 });
  }
  mesh.triangles = { { 5, 1, 3 }, { 3, 3, 3 } };
  mesh.attributes = { Numbers(AttributeAssociation::Point, { 10, 11, 12, 13, 14, 15 }),
    Numbers(AttributeAssociation::Cell, { 7, 8 }) };
  const Mesh unused = TakeUnusedVertices(mesh, FindUsedVertices(mesh));
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{ { 1, 0, 0 }, { 3, 0, 0 }, { 5, 0, 0 } }));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{ { 2, 0, 1 }, { 1, 1, 1 } }));
  EXPECT_EQ(mesh.attributes[0].values, (std::vector<std::uint8_t>{ 11, 13, 15 }));
  EXPECT_EQ(mesh.attributes[1].values, (std::vector<std::uint8_t>{ 7, 8 }));
  EXPECT_EQ(unused.points, (std::vector<Vec3>{ { 0, 0, 0 }, { 2, 0, 0 }, { 4, 0, 0 } }));
  EXPECT_TRUE(unused.triangles.empty());
  ASSERT_EQ(unused.attributes.size(), 1U);
  EXPECT_EQ(unused.attributes[0].values, (std::vector<std::uint8_t>{ 10, 12, 14 }));
}

TEST(UnusedVertices, ACloudHasNone)
{
  const Mesh cloud{ { { 1, 2, 3 }, { 4, 5, 6 } }, {}, ScalarType::Float64, {} };
  EXPECT_EQ(FindUsedVertices(cloud), (std::vector<bool>{ true, true }));
}
