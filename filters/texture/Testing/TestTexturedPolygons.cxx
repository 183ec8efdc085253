// SPDX-License-Identifier: BSD-3-Clause
// Concave polygons of textured OBJ and PLY files are cut correctly, and each corner keeps its
// texture coordinate.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/core/VectorMath.h"
#include "filters/texture/FindTextures.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

TEST(TexturedPolygons, ConcaveOnesAreCutWithTheirCoordinates)
{
  const fixtures::TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl m\nmap_Kd a.png\n");
  const std::pair<const char*, std::string> files[] = {
    { "a.obj", "mtllib a.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
               "vt 0.5 0.25\nvt 0 1\nvn 0 0 1\nusemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1 5/5/1\n" },
    { "a.ply", "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 5\nproperty float "
               "x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int "
               "vertex_indices\nproperty list uchar float texcoord\nend_header\n0 0 0\n4 0 0\n4 4 "
               "0\n2 1 0\n0 4 0\n5 0 1 2 3 4 10 0 0 1 0 1 1 0.5 0.25 0 1\n" }
  };
  for (const auto& [name, text] : files)
  {
    SCOPED_TRACE(name);
    const Result<TexturedFile> read = ReadTextured(folder.Write(name, text));
    ASSERT_TRUE(read) << read.GetError().message;
    const TexturedMesh& textured = read->textured;
    const Mesh& mesh = textured.mesh;
    ASSERT_EQ(mesh.triangles.size(), 3U);
    ASSERT_EQ(textured.corners.size(), 3U);
    double area = 0;
    for (std::size_t i = 0; i < 3; ++i)
    {
      const Triangle& t = mesh.triangles[i];
      const Vec3& a = mesh.points[t[0]];
      area += Length(Cross(Minus(mesh.points[t[1]], a), Minus(mesh.points[t[2]], a))) / 2;
      for (std::size_t k = 0; k < 3; ++k)
      {
        EXPECT_EQ(double(textured.corners[i][k][0]) * 4, mesh.points[t[k]][0]);
        EXPECT_EQ(double(textured.corners[i][k][1]) * 4, mesh.points[t[k]][1]);
      }
    }
    EXPECT_EQ(area, 10);
  }
}

}
