// SPDX-License-Identifier: BSD-3-Clause
// Reads a mesh from a file, welded as by the builder, without attributes: for benchmarks of levels.
#pragma once

#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"

#include <cstdlib>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <utility>

namespace kdstream::bench
{

// Returns the result. A failed step ends the program, because there is nothing to measure then.
template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    std::cerr << "error: " << result.GetError().message << "\n";
    std::exit(2);
  }
  return std::move(*result);
}

inline Mesh ReadWelded(const std::string& file, bool keepAttributes = false)
{
  Mesh mesh;
  const std::unique_ptr<MeshReader> reader = Need(MeshReader::Open(file));
  Need(reader->ReadVertices(mesh, std::numeric_limits<std::size_t>::max()));
  Need(reader->ReadTriangles(mesh, std::numeric_limits<std::size_t>::max()));
  if (!keepAttributes)
  {
    mesh.attributes.clear();
  }
  WeldVertices(mesh);
  return mesh;
}

}
