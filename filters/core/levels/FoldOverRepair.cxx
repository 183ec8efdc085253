// SPDX-License-Identifier: BSD-3-Clause
// For each part:
//   1. Find the triangles that face the wrong way; if there are none, nothing is to be done.
//   2. List the triangles of each cluster.
//   3. Visit the clusters of these triangles, in ascending order, until none can be improved.
#include "filters/core/levels/FoldOverRepair.h"

#include "filters/core/VectorMath.h"
#include "filters/core/levels/CollapseRound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr unsigned mostSweeps = 8;
constexpr unsigned mostSteps = 16;    // of a relaxation
constexpr double towardsPlanes = 0.5; // regularisation of the quadric after each step
// The least distance of a vertex from the edges around it, as a share of their length. Tried one
// after the other.
constexpr std::array<double, 2> margins = { 0.1, 0.02 };
constexpr std::size_t mostSides = 256; // of a cluster that is moved

// A place is tried only up to a limit distance from the cluster's planes, in lengths of the
// cluster's longest edge. These limits are used one after the other, so that near places are found
// first, whichever of a triangle's clusters moves. Limits above `mostOfCoarse` are used only in
// levels of at least 2^fineLevel clusters: in coarser levels a spike is more visible than a fold.
constexpr double mostOfCoarse = 0.07;
// For levels with colours, which have long edges where colours do not matter: there a notch in the
// outline is more visible than a fold. Measured.
constexpr double mostOfColored = 0.04;
constexpr unsigned fineLevel = 11;
constexpr std::array<double, 7> limits = { 0.005, 0.01, 0.02, 0.04, 0.07, 0.15, 0.3 };

// A triangle around a cluster.
struct Side
{
  Vec3 first, second; // the other corners, in the triangle's order
  Vec3 reference;     // where the triangle should face
  // The unit vector at a right angle to the edge, towards the inside, or 0 if there is none; and
  // the edge's length.
  Vec3 inward;
  double length;
};

class PartFoldOverRepair
{
public:
  PartFoldOverRepair(const CollapseState& block, const CollapseSpace& space, unsigned level,
    std::span<const std::uint32_t> triangles, VertexId begin, VertexId end)
    : Block(block)
    , Space(space)
    , Level(level)
    , Numbers(triangles)
    , Begin(begin)
    , End(end)
  {
  }

  std::vector<MovedCluster> Run()
  {
    this->Facing.reserve(this->End - this->Begin + 1);
    for (VertexId c = this->Begin; c < this->End; ++c)
    {
      this->Facing.push_back(this->SumOf(c).Facing());
    }
    this->Facing.push_back({});
    const std::vector<std::uint32_t> opposed = this->FindOpposed();
    if (opposed.empty())
    {
      return {};
    }
    const auto at = this->Block.level.positions.begin();
    this->Places.assign(at + this->Begin, at + this->End);
    this->Waits.assign(this->Places.size(), 0);
    this->Needs.assign(this->Places.size(), 0);
    for (const std::uint32_t number : opposed)
    {
      this->Mark(this->Block.level.triangles[number]);
    }
    this->ListSides();
    const double most = this->IsColored()          ? mostOfColored
                        : this->Level >= fineLevel ? limits.back()
                                                   : mostOfCoarse;
    for (const double limit : limits)
    {
      if (limit <= most)
      {
        this->Repair(limit);
      }
    }
    return this->Moved();
  }

private:
  const ClusterSum& SumOf(VertexId c) const
  {
    return this->Block.clusters[c - this->Block.ownBegin];
  }
  bool IsOwn(VertexId c) const { return c >= this->Begin && c < this->End; }
  const Vec3& PlaceOf(VertexId c) const
  {
    return this->IsOwn(c) ? this->Places[c - this->Begin] : this->Block.level.positions[c];
  }

  // 0 for clusters of other parts: below the first own one the difference is huge.
  const Vec3& FacingOf(VertexId c) const
  {
    return this->Facing[std::min<VertexId>(c - this->Begin, this->End - this->Begin)];
  }

  // The sum of the directions in which the part's own corners face.
  Vec3 ReferenceOf(const Triangle& t) const
  {
    return Plus(Plus(this->FacingOf(t[0]), this->FacingOf(t[1])), this->FacingOf(t[2]));
  }

  // The numbers of the triangles that face the wrong way at first.
  std::vector<std::uint32_t> FindOpposed() const
  {
    const std::vector<Vec3>& at = this->Block.level.positions;
    std::vector<std::uint32_t> opposed;
    for (const std::uint32_t number : this->Numbers)
    {
      const Triangle& t = this->Block.level.triangles[number];
      const Vec3 normal = Cross(Minus(at[t[1]], at[t[0]]), Minus(at[t[2]], at[t[0]]));
      if (Dot(normal, this->ReferenceOf(t)) < 0)
      {
        opposed.push_back(number);
      }
    }
    return opposed;
  }

  bool IsColored() const
  {
    const ClusterLevel& level = this->Block.level;
    std::vector<Triangle> triangles;
    if (!level.vertexColors.empty())
    {
      std::transform(this->Numbers.begin(), this->Numbers.end(), std::back_inserter(triangles),
        [&](std::uint32_t number) { return level.triangles[number]; });
    }
    return !IsOfOneColor(triangles, level.vertexColors);
  }

  void Mark(const Triangle& t)
  {
    for (const VertexId c : t)
    {
      if (this->IsOwn(c))
      {
        this->Waits[c - this->Begin] = 1;
        this->Needs[c - this->Begin] = 0;
      }
    }
  }

  template <class Visit>
  void ForEachOwnCorner(const Visit& visit) const
  {
    for (const std::uint32_t number : this->Numbers)
    {
      for (const VertexId c : this->Block.level.triangles[number])
      {
        if (this->IsOwn(c))
        {
          visit(c - this->Begin, number);
        }
      }
    }
  }

  // Lists the triangles of each cluster, cluster by cluster.
  void ListSides()
  {
    this->First.assign(this->Places.size() + 2, 0);
    this->ForEachOwnCorner([&](std::size_t own, std::uint32_t) { ++this->First[own + 2]; });
    std::partial_sum(this->First.begin(), this->First.end(), this->First.begin());
    this->Around.resize(this->First.back());
    this->ForEachOwnCorner([&](std::size_t own, std::uint32_t number)
      { this->Around[this->First[own + 1]++] = number; });
  }

  std::span<const std::uint32_t> TrianglesAround(VertexId c) const
  {
    const std::uint32_t first = this->First[c - this->Begin];
    return std::span(this->Around).subspan(first, this->First[c - this->Begin + 1] - first);
  }

  void GatherSides(VertexId c)
  {
    this->Sides.clear();
    for (const std::uint32_t number : this->TrianglesAround(c))
    {
      const Triangle& t = this->Block.level.triangles[number];
      const std::size_t k = t[0] == c ? 0 : t[1] == c ? 1 : 2;
      const Vec3 &first = this->PlaceOf(t[(k + 1) % 3]), &second = this->PlaceOf(t[(k + 2) % 3]);
      const Vec3 edge = Minus(second, first), reference = this->ReferenceOf(t);
      const Vec3 across = Cross(reference, edge);
      const double length = Length(across);
      this->Sides.push_back({ first, second, reference,
        length > 0 ? Times(across, 1 / length) : Vec3{}, length > 0 ? Length(edge) : 0 });
    }
  }

  // How many of the triangles around the cluster would face the wrong way if it were at a place.
  std::size_t OpposedAt(const Vec3& place) const
  {
    return static_cast<std::size_t>(std::count_if(this->Sides.begin(), this->Sides.end(),
      [&](const Side& side) {
        return Dot(Cross(Minus(side.first, place), Minus(side.second, place)), side.reference) < 0;
      }));
  }

  // Visits the waiting clusters until none moves. Clusters without a better place within the limit
  // continue to wait.
  void Repair(double limit)
  {
    bool any = true;
    for (unsigned sweep = 0; sweep < mostSweeps && any; ++sweep)
    {
      any = false;
      for (VertexId c = this->Begin; c < this->End; ++c)
      {
        const std::size_t own = c - this->Begin;
        if (this->Waits[own] == 0 || this->Needs[own] > limit)
        {
          continue;
        }
        this->Waits[own] = 0;
        this->GatherSides(c);
        const std::size_t opposed = this->OpposedAt(this->Places[own]);
        if (opposed > 0 && this->Sides.size() <= mostSides)
        {
          const bool moves = this->Move(c, opposed, limit);
          any |= moves;
          this->Waits[own] = 1;
        }
      }
    }
  }

  // Moves a cluster, whose sides are gathered, to a place within the limit where fewer than
  // `opposed` of its triangles face the wrong way: the place with the fewest; of equals, the
  // nearest to its planes. Returns whether there is one.
  bool Move(VertexId c, std::size_t opposed, double limit)
  {
    const Vec3 old = this->PlaceOf(c);
    const Quadric& quadric = this->SumOf(c).quadric;
    double longest = 0;
    for (const Side& side : this->Sides)
    {
      longest = std::max(longest, SquaredDistance(old, side.first));
    }
    const double tolerated = quadric.At(this->Space.Relative(old));
    const double scale = longest * quadric.Trace(); // factor on the square of a limit
    const double most = std::max(tolerated, limit * limit * scale);
    Vec3 best = old;
    std::size_t least = opposed;
    double error = 0, needed = std::numeric_limits<double>::infinity();
    const auto attempt = [&](const Vec3& place)
    {
      const double here = quadric.At(this->Space.Relative(place));
      const bool near = here <= most;
      if (!near && here >= needed)
      {
        return;
      }
      const std::size_t now = this->OpposedAt(place);
      if (now >= opposed)
      {
        return;
      }
      needed = std::min(needed, here);
      if (near && (now < least || (now == least && here < error)))
      {
        best = place;
        least = now;
        error = here;
      }
    };
    for (const double margin : margins)
    {
      attempt(this->Relaxed(old, margin, quadric));
    }
    for (const Side& side : this->Sides)
    {
      attempt(side.first);
      attempt(side.second);
    }
    if (least == opposed)
    {
      this->Needs[c - this->Begin] = std::sqrt(needed / scale);
      return false;
    }
    this->Places[c - this->Begin] = best;
    for (const std::uint32_t number : this->TrianglesAround(c))
    {
      this->Mark(this->Block.level.triangles[number]);
    }
    return true;
  }

  // Starting from `place`, the nearest place where all triangles around the cluster would face the
  // right way, if there is one and it is found in a few steps. For a fixed edge and reference
  // direction, the places where a triangle faces the right way form a half space.
  Vec3 Relaxed(Vec3 place, double margin, const Quadric& quadric) const
  {
    for (unsigned step = 0; step < mostSteps; ++step)
    {
      double farthest = 0;
      const Side* beyond = nullptr;
      for (const Side& side : this->Sides)
      {
        const double missing = margin * side.length - Dot(side.inward, Minus(place, side.first));
        beyond = missing > farthest ? &side : beyond;
        farthest = missing > farthest ? missing : farthest;
      }
      if (!beyond)
      {
        break;
      }
      const Vec3 to = Plus(place, Times(beyond->inward, farthest));
      place = this->Space.Absolute(quadric.Minimum(this->Space.Relative(to), towardsPlanes));
    }
    return place;
  }

  std::vector<MovedCluster> Moved() const
  {
    std::vector<MovedCluster> moved;
    for (VertexId c = this->Begin; c < this->End; ++c)
    {
      const Vec3& place = this->Places[c - this->Begin];
      if (place != this->Block.level.positions[c])
      {
        const ClusterSum& sum = this->SumOf(c);
        moved.push_back({ c, place,
          std::max(sum.geometricError, sum.GeometricErrorAt(this->Space.Relative(place))) });
      }
    }
    return moved;
  }

  const CollapseState& Block;
  const CollapseSpace& Space;
  unsigned Level;
  std::span<const std::uint32_t> Numbers;
  VertexId Begin, End;
  // Of the own clusters:
  std::vector<Vec3> Places;
  std::vector<Vec3> Facing;          // sums of their triangles' area vectors; 0 after them
  std::vector<std::uint8_t> Waits;   // whether the cluster must be examined
  std::vector<double> Needs;         // no place below this limit is better, until a neighbour moves
  std::vector<std::uint32_t> First;  // in Around
  std::vector<std::uint32_t> Around; // numbers of triangles
  std::vector<Side> Sides;           // of the current cluster
};

}

BlockParts PartsOfLevel(
  const TreeDepths& depths, unsigned level, unsigned blockDepth, std::size_t block)
{
  const unsigned part = PartDepthOf(depths, level);
  const std::size_t count = std::size_t{ 1 } << (part - blockDepth);
  return { depths.finest - part, block * count, count };
}

std::vector<MovedCluster> RepairFoldOvers(const CollapseState& block, const CollapseSpace& space,
  unsigned level, const BlockParts& parts, const Execution& execution)
{
  const PartTriangles of(block, parts, execution);
  std::vector<std::vector<MovedCluster>> moved(parts.count);
  execution.parallelFor(parts.count, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t p = begin; p < end; ++p)
      {
        moved[p] =
          PartFoldOverRepair(block, space, level, of.buckets.Of(p), of.begin[p], of.begin[p + 1])
            .Run();
      }
    });
  std::vector<MovedCluster> all;
  for (const std::vector<MovedCluster>& part : moved)
  {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}
