// SPDX-License-Identifier: BSD-3-Clause
// Prepares a mesh before readers append to it. Part of step "read".
#pragma once

#include "filters/meshio/MeshReader.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kdstream
{

// Reserves room for `count` more items, and still grows by doubling. REQUIRES: the file has bytes
// for `count` items.
template <class T>
void MakeRoom(std::vector<T>& items, std::uint64_t count)
{
  const std::size_t wanted = items.size() + static_cast<std::size_t>(count);
  if (wanted > items.capacity())
  {
    items.reserve(std::max(wanted, 2 * items.capacity()));
  }
}

// Sets the mesh's scalar type, and creates the arrays if the mesh has none.
inline void PrepareArrays(Mesh& mesh, const MeshFileInfo& info)
{
  mesh.scalarType = info.scalarType;
  if (mesh.attributes.empty())
  {
    for (const AttributeInfo& array : info.attributes)
    {
      mesh.attributes.push_back({ array, {} });
    }
  }
}

}
