// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CoarserState.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::size_t stateGrain = 1 << 14;

// Positions, deviations and lowest vertices.
void Place(const CollapseState& below, const Merging& merging, const CollapseSpace& space,
  Representative representative, std::span<const VertexId> standing, CollapseState& state,
  const Execution& execution)
{
  ClusterLevel& level = state.level;
  level.positions.resize(standing.size());
  level.deviations.resize(standing.size());
  level.lowest.resize(standing.size());
  execution.parallelFor(standing.size(), stateGrain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        ClusterSum& cluster = state.clusters[i];
        const VertexId c = standing[i];
        switch (merging.PositionOf(c))
        {
          case Merging::Position::Kept:
            level.positions[i] = below.level.positions[c];
            break;
          case Merging::Position::Moved:
            level.positions[i] = space.Absolute(merging.MovedTo(c));
            break;
          case Merging::Position::Grouped:
            level.positions[i] = cluster.Represent(representative, space.origin);
            break;
        }
        cluster.deviation =
          std::max(cluster.deviation, cluster.DeviationAt(space.Relative(level.positions[i])));
        level.deviations[i] = cluster.deviation;
        level.lowest[i] = cluster.lowest;
      }
    });
}

}

CollapseState MakeCoarser(const CollapseState& below, const Merging& merging,
  const CollapseSpace& space, Representative representative, std::vector<VertexId>& parents,
  const Execution& execution)
{
  CollapseState state;
  const std::vector<VertexId> standing = merging.Standing();
  std::vector<VertexId> number(below.OwnCount());
  for (std::size_t i = 0; i < standing.size(); ++i)
  {
    number[standing[i] - below.ownBegin] = static_cast<VertexId>(i);
    state.cellOf.push_back(merging.FinestCellOf(standing[i]));
  }
  parents.resize(number.size());
  state.clusters.resize(standing.size());
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    const auto c = static_cast<VertexId>(below.ownBegin + i);
    parents[i] = number[merging.StandsFor(c) - below.ownBegin];
    state.clusters[parents[i]].Add(below.clusters[i]);
  }
  Place(below, merging, space, representative, standing, state, execution);
  state.attributes =
    MeanOverChildren(below.attributes, below.clusters, parents, state.clusters.size());
  state.ownEnd = static_cast<VertexId>(standing.size());
  return state;
}

}
