// SPDX-License-Identifier: BSD-3-Clause
// A mesh file, read as a whole.
#pragma once

#include "filters/meshio/MeshReader.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace kdstream::fixtures
{

// A test fails if the file cannot be read.
inline Mesh ReadMeshFile(const std::filesystem::path& file)
{
  constexpr std::size_t all = ~std::size_t{ 0 };
  Mesh mesh;
  const auto reader = MeshReader::Open(file);
  EXPECT_TRUE(reader) << file << ": " << reader.GetError().message;
  if (reader)
  {
    mesh.scalarType = (*reader)->Info().scalarType;
    EXPECT_TRUE((*reader)->ReadVertices(mesh, all));
    EXPECT_TRUE((*reader)->ReadTriangles(mesh, all));
  }
  return mesh;
}

}
