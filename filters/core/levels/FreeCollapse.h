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

// Where the sums of a level's clusters are put while its edges collapse; the collapse takes about
// as much memory as the level. This class leaves them in memory.
class SumsAside
{
public:
  virtual ~SumsAside() = default;
  // Leaves none. Errors: its own.
  virtual Status Put(std::vector<ClusterSum>& /*sums*/) { return {}; }
  // Gives back what was put.
  virtual Status Return(std::vector<ClusterSum>& /*sums*/) { return {}; }
};

// What is collapsed of a whole level.
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

// Decides what merges from a whole level to the next coarser one, `depth`. Edges collapse until
// about `surface` clusters with triangles are left, and then further in nodes that would hold too
// much (MostOfNode). If edges are not enough, clusters are grouped by cells. Memory about 350 bytes
// a cluster of surfaces, beside the state without its sums. Keeps references to below and depths.
// Errors: those of `aside`.
Result<Merging> CollapseFreely(CollapseState& below, const CollapseSpace& space,
  const TreeDepths& depths, unsigned depth, std::size_t surface, bool byComponents,
  SumsAside& aside);

}
