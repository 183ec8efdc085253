// SPDX-License-Identifier: BSD-3-Clause
// The triangles around the vertex that an edge would collapse to. Only for EdgeCollapse.
#pragma once

#include "filters/core/Lanes.h"
#include "filters/core/Types.h"
#include "filters/core/collapse/VertexStars.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

class MergedStar
{
public:
  // Whether the normal of a triangle turns by more than about 80° when its corner p goes to another
  // place. KeepsNormals checks a whole star for this.
  static bool TurnsNormal(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& to);

  // star: of the edge from u to v. position: of the merged vertex.
  void Set(std::span<const Vec3> positions, const EdgeStar& star, VertexId u, VertexId v,
    const Vec3& position);
  // Whether no triangle's normal turns by more than about 80°.
  bool KeepsNormals() const { return !this->Turns; }
  // How far the surface retreats, as a squared distance: the largest distance to the new triangles
  // from an end of the edge, or from a vertex that faces the edge. Quadrics do not notice this: the
  // tip of a limb can retreat along the limb without leaving the planes. If no triangle is left, it
  // is the longest side of the removed ones. A result of at most `enough` / `scale` need not be
  // exact. The other arguments are those of Set.
  double SquaredRetreat(std::span<const Vec3> positions, const EdgeStar& star, VertexId u,
    VertexId v, double scale, double enough) const;

private:
  // Two triangles; if their number is odd, the last one fills both lanes.
  struct Pair
  {
    std::array<Lanes, 3> a, b; // sides from the merged vertex
    Lanes aa, ab, bb, determinant;
  };

  Lanes SquaredToInsides(const Vec3& p) const;
  double SquaredToTriangles(
    const Vec3& p, std::span<const Vec3> positions, const EdgeStar& star, double least) const;
  bool IsOnSide(const EdgeStar& star, VertexId w) const;

  std::vector<Pair> Pairs;
  Vec3 Position{};
  bool Turns = false;
};

}
