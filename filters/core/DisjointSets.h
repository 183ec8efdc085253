// SPDX-License-Identifier: BSD-3-Clause
// Disjoint sets as a forest in one array: parent[v] == v is a root, the lowest of its set.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <vector>

namespace kdstream
{

inline VertexId FindRoot(std::vector<VertexId>& parent, VertexId v)
{
  while (parent[v] != v)
  {
    parent[v] = parent[parent[v]];
    v = parent[v];
  }
  return v;
}

inline void Join(std::vector<VertexId>& parent, VertexId a, VertexId b)
{
  a = FindRoot(parent, a);
  b = FindRoot(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

}
