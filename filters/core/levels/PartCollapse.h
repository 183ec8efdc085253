// SPDX-License-Identifier: BSD-3-Clause
// Collapses the parts of a block, each by itself with the clusters of other parts fixed: part of
// step "levels" of the pipeline picture. Only for the makers of levels.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/LevelBlocks.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The parts of a block: `count` nodes of one depth, from `first` on.
struct BlockParts
{
  unsigned belowPart = 0; // depths from a part to the finest cells
  std::size_t first = 0, count = 0;

  std::size_t Of(std::uint32_t finestCell) const
  {
    return (finestCell >> this->belowPart) - this->first;
  }
};

// The clusters and triangles of each part of a block.
struct PartTriangles
{
  PartTriangles(
    const CollapseState& block, const BlockParts& parts, const Execution& execution = {});

  std::vector<VertexId> begin; // the first cluster of each part, and the end
  // For each part the triangles that touch it; one more bucket for ghosts.
  TriangleBuckets buckets;
};

// Collapses parts, as many at once as there are threads.
class PartCollapse
{
public:
  // share: the number of clusters with triangles that a part keeps on average; every part is
  // collapsed at least to this number. areaPerVertex: the average of the level. Keeps references to
  // block and space.
  PartCollapse(const CollapseState& block, const CollapseSpace& space, const BlockParts& parts,
    std::size_t share, double areaPerVertex, const Execution& execution);

  // The number of clusters of a part, including those without triangles. Parts are numbered from
  // the block's first one.
  std::uint32_t ClustersOf(std::size_t part) const
  {
    return this->Of.begin[part + 1] - this->Of.begin[part];
  }
  // Makes the lists of these parts anew. enough: once a part is down to the share, merges that cost
  // more than this need not be found. A list made again with a greater `enough` begins with the
  // same merges. O(m log m) for m clusters and triangles.
  void Collapse(
    std::span<const std::size_t> parts, double enough, std::span<MergeList> lists) const;

private:
  MergeList MergesOf(std::size_t part, double enough) const;
  CollapsePart Extract(std::size_t part) const;

  const CollapseState& Block;
  const CollapseSpace& Space;
  std::size_t Share;
  double AreaPerVertex;
  const Execution& Exec;
  PartTriangles Of;
};

}
