// SPDX-License-Identifier: BSD-3-Clause
// Moves the representatives of a level in places where triangles face the wrong way. Only for the
// makers of levels.
//
// A triangle should face as its three clusters do. The direction in which they face is the sum of
// the area vectors of their triangles. Cells of a tree have any shape, so the triangle of the means
// of three neighbouring cells may be flipped. If a cluster touches only two others, its two
// triangles always coincide. Only positions change: the triangles stay the image of the original.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/PartCollapse.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// A cluster of a state and its new place, absolute.
struct MovedCluster
{
  VertexId cluster;
  Vec3 position;
  double geometricError; // the new one, never below the old one
};

// The parts of a block in which the clusters of a level have collapsed. A block is a cell of
// `blockDepth`.
BlockParts PartsOfLevel(
  const TreeDepths& depths, unsigned level, unsigned blockDepth, std::size_t block);

// One pass over a block. Returns its own clusters that move, ascending. Each part moves its own
// clusters; clusters of other parts stay at their places in the state. So the result depends only
// on the part's own clusters and the triangles that touch them, not on blocks or threads. A cluster
// with triangles that face the wrong way moves to a near place where fewer of them do; if there is
// none, to the place of a neighbour, so that the triangles between the two vanish. O(t) for t
// triangles. Source: the half spaces around a star's kernel by relaxation, Agmon 1954, Motzkin and
// Schoenberg 1954; the rest is ours.
std::vector<MovedCluster> RepairFoldOvers(const CollapseState& block, const CollapseSpace& space,
  unsigned level, const BlockParts& parts, const Execution& execution = {});

}
