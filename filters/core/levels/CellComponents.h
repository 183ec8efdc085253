// SPDX-License-Identifier: BSD-3-Clause
// Decides which connected components of one cell become clusters of their own
// (doc/design.md#clusters). Only for the makers of levels.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

inline constexpr std::size_t mostCellComponents = 4; // per cell

// A component of one cell, before it is decided which components become clusters of their own.
struct CellComponent
{
  std::uint64_t count = 0; // original vertices
  Vec3 sum{};
  bool surface = false;
  std::size_t joined = 0; // the component that this one is joined to
};

// Joins components of one cell until at most four are left. First joins all components without
// triangles. If more than 16 are left, each of the smaller ones joins the nearest of the 16
// largest. Then, until four are left, one of the smallest components joins another one: of these
// pairs, the one with the least distance. Distances are between means; among equals the lowest
// vertex decides. `components` are ordered by lowest vertex.
void LimitComponents(std::vector<CellComponent>& components);

// Groups the members of one cell into clusters. members: ordered by lowest original vertex.
// root(m): the id of the root of the member's component. describe(m): its CellComponent. Calls
// assign(m, local cluster); returns the number of clusters. Local clusters are ordered by lowest
// vertex.
template <class Root, class Describe, class Assign>
std::size_t GroupCell(std::span<const VertexId> members, bool byComponents, const Root& root,
  const Describe& describe, const Assign& assign)
{
  if (members.empty())
  {
    return 0;
  }
  if (!byComponents)
  {
    for (const VertexId m : members)
    {
      assign(m, 0);
    }
    return 1;
  }
  std::vector<VertexId> roots;
  std::vector<CellComponent> components;
  std::vector<std::size_t> componentOf(members.size());
  for (std::size_t i = 0; i < members.size(); ++i)
  {
    const VertexId r = root(members[i]);
    const auto found = std::find(roots.begin(), roots.end(), r);
    componentOf[i] = static_cast<std::size_t>(found - roots.begin());
    const CellComponent own = describe(members[i]);
    if (found == roots.end())
    {
      roots.push_back(r);
      components.push_back(own);
      continue;
    }
    CellComponent& component = components[componentOf[i]];
    component.count += own.count;
    component.surface |= own.surface;
    for (std::size_t k = 0; k < 3; ++k)
    {
      component.sum[k] += own.sum[k];
    }
  }
  LimitComponents(components);
  // Local numbers in the order of first appearance, which is that of the lowest vertex.
  std::vector<std::size_t> number(components.size(), components.size());
  std::size_t clusters = 0;
  for (std::size_t i = 0; i < members.size(); ++i)
  {
    std::size_t& n = number[components[componentOf[i]].joined];
    if (n == components.size())
    {
      n = clusters++;
    }
    assign(members[i], n);
  }
  return clusters;
}

}
