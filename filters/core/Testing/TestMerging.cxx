// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/Merging.h"

#include <gtest/gtest.h>

#include <vector>

using namespace kdstream;

namespace
{

// Eight clusters of one vertex each on a tree of two cells: two triangles in cell 0, and two more
// that link them through cell 1.
CollapseState TwoComponentsInACell()
{
  CollapseState state;
  state.ownEnd = 8;
  state.cellOf = { 0, 0, 0, 0, 0, 0, 1, 1 };
  state.level.triangles = { { 0, 1, 2 }, { 2, 6, 7 }, { 3, 4, 5 }, { 3, 6, 7 } };
  for (VertexId c = 0; c < 8; ++c)
  {
    state.level.positions.push_back({ double(c), 0, 0 });
    state.level.lowest.push_back(c);
    state.clusters.emplace_back().count = 1;
    state.clusters.back().sum = state.level.positions.back();
  }
  return state;
}

const TreeDepths depths{ 1, 1, 1 };

}

TEST(Merging, FullNodesAreGroupedByComponentsWhichAreConnectedInsideOneCell)
{
  const CollapseState state = TwoComponentsInACell();
  Merging merging(state, depths, 1);
  merging.GroupLoose();
  merging.GroupNodes(std::vector<std::uint8_t>(merging.NodeCount(), 1), true);
  EXPECT_EQ(merging.Targets(), (std::vector<VertexId>{ 0, 0, 0, 3, 3, 3, 6, 6 }));
}

TEST(Merging, FullNodesAreGroupedByCellsWithoutComponents)
{
  const CollapseState state = TwoComponentsInACell();
  Merging merging(state, depths, 1);
  merging.GroupLoose();
  merging.GroupNodes(std::vector<std::uint8_t>(merging.NodeCount(), 1), false);
  EXPECT_EQ(merging.Targets(), (std::vector<VertexId>{ 0, 0, 0, 0, 0, 0, 6, 6 }));
}
