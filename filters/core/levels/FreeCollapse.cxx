// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/FreeCollapse.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kdstream
{

CollapsePart PartOfWholeLevel(const CollapseState& state, const CollapseSpace& space)
{
  CollapsePart part;
  part.components = state.attributes.components;
  part.bounds = space.RelativeBox();
  part.keepTopology = false; // handles would use up the few vertices of these levels
  part.positions.reserve(state.clusters.size());
  part.quadrics.reserve(state.clusters.size());
  for (VertexId c = 0; c < state.clusters.size(); ++c)
  {
    AppendCluster(state, space, c, part);
  }
  part.triangles = state.level.triangles;
  AddColorQuadrics(
    state.level.vertexColors, state.clusters.size(), GreyValue(DiagonalOf(space.box)), part);
  part.areaPerVertex = AddAreas(0, state.clusters) / double(state.clusters.size());
  return part;
}

namespace
{

Result<Merging> MergeEdges(CollapseState& below, const CollapseSpace& space,
  const TreeDepths& depths, unsigned depth, std::size_t surface, SumsAside& aside)
{
  CollapsePart part = PartOfWholeLevel(below, space);
  KDSTREAM_TRY(aside.Put(below.clusters));
  FreeCollapse collapse(std::move(part));
  bool more = collapse.Run(surface, EdgeCollapse::any);
  for (;;)
  {
    Merging merging(below, depths, depth);
    collapse.Apply(merging);
    merging.GroupLoose();
    // Only nodes that would hold too many clusters continue to collapse.
    const std::vector<std::size_t> excess = merging.ExcessOfNodes();
    const std::size_t total = std::accumulate(excess.begin(), excess.end(), std::size_t{ 0 });
    if (total == 0 || !more || collapse.VertexCount() == 0)
    {
      return merging;
    }
    collapse.Restrict([&](VertexId v) { return excess[merging.NodeOf(merging.StandsFor(v))] > 0; });
    more = collapse.Run(
      collapse.VertexCount() - std::min(collapse.VertexCount(), total), EdgeCollapse::any);
  }
}

}

FreeCollapse::FreeCollapse(CollapsePart part)
  : Clusters(part.positions.size())
  , Engine(std::move(part))
{
}

Result<Merging> CollapseFreely(CollapseState& below, const CollapseSpace& space,
  const TreeDepths& depths, unsigned depth, std::size_t surface, bool byComponents,
  SumsAside& aside)
{
  Result<Merging> merging = MergeEdges(below, space, depths, depth, surface, aside);
  KDSTREAM_TRY(merging);
  KDSTREAM_TRY(aside.Return(below.clusters));
  const std::vector<std::uint8_t> full = FullNodes(merging->ExcessOfNodes());
  if (!full.empty())
  {
    merging->GroupNodes(full, byComponents);
    merging->GroupLoose(); // clusters that have lost their last triangles
  }
  return merging;
}

}
