// SPDX-License-Identifier: BSD-3-Clause
// Collapses a whole level at once, for small levels coarser than S. Only for the makers of levels.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/Merging.h"

#include <vector>

namespace kdstream
{

// Where the sums of a level's clusters are kept while its edges collapse, because the collapse
// takes about as much memory as the level. This base class leaves them in memory.
class SumsAside
{
public:
  virtual ~SumsAside() = default;
  // Stores the sums elsewhere and empties `sums`. Errors: those of the implementation.
  virtual Status Put(std::vector<ClusterSum>& /*sums*/) { return {}; }
  // Restores the sums that Put took.
  virtual Status Return(std::vector<ClusterSum>& /*sums*/) { return {}; }
};

// A whole level as a part to be collapsed.
CollapsePart PartOfWholeLevel(const CollapseState& state, const CollapseSpace& space);

class FreeCollapse
{
public:
  explicit FreeCollapse(CollapsePart part);

  bool Run(std::size_t vertices, std::size_t triangles)
  {
    return this->Engine.Run(vertices, triangles);
  }
  // Only vertices for which movable(v) is true may collapse from now on.
  template <class Movable>
  void Restrict(const Movable& movable)
  {
    for (VertexId v = 0; v < this->Clusters; ++v)
    {
      if (!movable(v))
      {
        this->Engine.Fix(v);
      }
    }
  }
  std::size_t VertexCount() const { return this->Engine.VertexCount(); }
  void Apply(Merging& merging) const { merging.Apply(this->Engine.Merges()); }

private:
  std::size_t Clusters;
  EdgeCollapse Engine;
};

// Decides which clusters of a whole level merge for the next coarser level, `depth`. Edges collapse
// until about `surface` clusters with triangles are left, and then further in nodes that would hold
// too many clusters (MostOfNode). If that is not enough, clusters are grouped by cells. Memory:
// about 350 bytes for each cluster with triangles, in addition to the state without its sums. Keeps
// references to below and depths. Errors: those of `aside`.
Result<Merging> CollapseFreely(CollapseState& below, const CollapseSpace& space,
  const TreeDepths& depths, unsigned depth, std::size_t surface, bool byComponents,
  SumsAside& aside);

}
