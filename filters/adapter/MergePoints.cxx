// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Sort the points that may be the same, by id or by place.
// 2. In each run of the same points, decide which one stays.
// 3. Assign new numbers.
#include "filters/adapter/MergePoints.h"

#include "filters/core/MixBits.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>

namespace kdstream
{
namespace
{

// As a part of the diagonal: points with the same id that are at most this far apart count as one
// place.
constexpr double idTolerance = 1.0 / (1 << 20);

// Calls visit(run) for each maximal run of equal neighbours.
template <class Equal, class Visit>
void ForEachRun(std::span<const VertexId> sorted, const Equal& equal, const Visit& visit)
{
  for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end)
  {
    while (end < sorted.size() && equal(sorted[begin], sorted[end]))
    {
      ++end;
    }
    visit(sorted.subspan(begin, end - begin));
  }
}

class Merging
{
public:
  Merging(const PartPoints& points, bool weldByPlace)
    : Points(points)
    , WeldByPlace(weldByPlace)
    , Target(points.places.size())
  {
    std::iota(this->Target.begin(), this->Target.end(), VertexId{ 0 });
  }

  MergedPoints Run()
  {
    MergedPoints merged;
    merged.byIds = !this->Points.ids.empty() && this->MergeById();
    if (!merged.byIds)
    {
      this->MergeByPlace();
    }
    merged.kept = std::move(this->Kept);
    merged.becomes.assign(this->Target.size(), noVertex);
    for (std::size_t i = 0; i < merged.kept.size(); ++i)
    {
      merged.becomes[merged.kept[i]] = static_cast<VertexId>(i);
    }
    for (std::size_t v = 0; v < this->Target.size(); ++v)
    {
      if (this->Points.isPresent[v])
      {
        merged.becomes[v] = merged.becomes[this->Target[v]];
      }
    }
    return merged;
  }

private:
  const Vec3& Place(VertexId v) const { return this->Points.places[v]; }
  std::size_t PartOf(VertexId v) const
  {
    const auto& first = this->Points.first;
    return std::size_t(std::upper_bound(first.begin(), first.end(), v) - first.begin());
  }
  std::vector<VertexId> Present() const
  {
    std::vector<VertexId> present;
    for (VertexId v = 0; v < this->Target.size(); ++v)
    {
      if (this->Points.isPresent[v])
      {
        present.push_back(v);
      }
    }
    return present;
  }

  // Returns false, and merges nothing, if the ids are not ids of points.
  bool MergeById()
  {
    const std::vector<std::int64_t>& ids = this->Points.ids;
    std::vector<VertexId> sorted = this->Present();
    std::stable_sort(
      sorted.begin(), sorted.end(), [&](VertexId a, VertexId b) { return ids[a] < ids[b]; });
    const double most = MostApart(this->Points.box.value_or(BoxOfPoints(this->Points.places)));
    bool believed = true;
    ForEachRun(
      sorted, [&](VertexId a, VertexId b) { return ids[a] == ids[b]; },
      [&](std::span<const VertexId> run)
      {
        const auto own =
          std::find_if(run.begin(), run.end(), [&](VertexId v) { return !this->Points.isCopy[v]; });
        const VertexId target = own != run.end() ? *own : run.front();
        for (const VertexId v : run)
        {
          believed = believed && SquaredDistance(this->Place(v), this->Place(target)) <= most;
          this->Target[v] = target;
        }
        this->Kept.push_back(target);
      });
    if (!believed)
    {
      std::iota(this->Target.begin(), this->Target.end(), VertexId{ 0 });
      this->Kept.clear();
    }
    return believed;
  }

  void MergeByPlace()
  {
    const std::vector<VertexId> sorted = this->Shared();
    ForEachRun(
      sorted, [&](VertexId a, VertexId b) { return this->Place(a) == this->Place(b); },
      [&](std::span<const VertexId> run)
      {
        if (run.size() > 1)
        {
          this->MergePlace(run);
        }
      });
    for (const VertexId v : this->Present())
    {
      if (this->Target[v] == v)
      {
        this->Kept.push_back(v);
      }
    }
  }

  // The points that other parts may also have, ordered by place: copies, and points in the same
  // places as copies.
  std::vector<VertexId> Shared() const
  {
    const auto byPlace = [this](VertexId a, VertexId b) { return this->Place(a) < this->Place(b); };
    std::vector<VertexId> shared = this->Present();
    if (!this->WeldByPlace)
    {
      std::vector<VertexId> copies;
      std::copy_if(shared.begin(), shared.end(), std::back_inserter(copies),
        [this](VertexId v) { return this->Points.isCopy[v]; });
      std::sort(copies.begin(), copies.end(), byPlace);
      std::erase_if(shared,
        [&](VertexId v) { return !std::binary_search(copies.begin(), copies.end(), v, byPlace); });
    }
    std::stable_sort(shared.begin(), shared.end(), byPlace);
    return shared;
  }

  // Points in one place that stay and have the same values in their arrays. next: which of them is
  // the next candidate for the current part.
  struct Alike
  {
    std::vector<VertexId> kept;
    std::size_t part = 0, next = 0;
  };

  // A hash of a point's arrays and of the signs of its zeros; a copy has the same hash.
  std::uint64_t Values(VertexId v) const
  {
    std::uint64_t signs = 0;
    for (const double x : this->Place(v))
    {
      signs = 2 * signs + (std::signbit(x) ? 1 : 0);
    }
    return MixBits(this->Points.hashOfArrays(v) + signs);
  }

  void MergePlace(std::span<const VertexId> run)
  {
    std::unordered_map<std::uint64_t, Alike> byArrays;
    std::vector<VertexId> firstOf; // the first that stays, and the first from another part
    for (const bool copies : { false, true })
    {
      for (const VertexId v : run)
      {
        if (this->Points.isCopy[v] != copies)
        {
          continue;
        }
        const std::size_t part = this->PartOf(v);
        Alike& alike = byArrays[this->Values(v)];
        if (std::exchange(alike.part, part) != part)
        {
          alike.next = 0;
        }
        const VertexId found =
          copies || this->WeldByPlace ? this->Find(v, part, alike, firstOf) : noVertex;
        if (found != noVertex)
        {
          this->Target[v] = found;
          continue;
        }
        alike.kept.push_back(v);
        ++alike.next;
        if (firstOf.empty() || (firstOf.size() == 1 && this->PartOf(firstOf[0]) != part))
        {
          firstOf.push_back(v);
        }
      }
      for (auto& [hash, alike] : byArrays)
      {
        alike.part = 0; // parts are counted from 1
      }
    }
  }

  // The point that v becomes; noVertex if v becomes a new point. Points of one part are different
  // points, unless they are copies: if one part holds the whole mesh, its copies may be there, too.
  VertexId Find(
    VertexId v, std::size_t part, Alike& alike, const std::vector<VertexId>& firstOf) const
  {
    const bool mayBeOwn = this->Points.first.size() == 2 && this->Points.isCopy[v];
    const auto isOther = [&](VertexId other) { return mayBeOwn || this->PartOf(other) != part; };
    std::vector<VertexId>& kept = alike.kept;
    while (alike.next < kept.size() && !isOther(kept[alike.next]))
    {
      ++alike.next;
    }
    if (alike.next < kept.size())
    {
      return kept[alike.next++];
    }
    if (!kept.empty() && (isOther(kept.front()) || isOther(kept.back())))
    {
      return noVertex; // all candidates are other points of this part
    }
    const auto other = std::find_if(
      firstOf.begin(), firstOf.end(), [&](VertexId first) { return this->PartOf(first) != part; });
    return other != firstOf.end() ? *other : noVertex;
  }

  const PartPoints& Points;
  bool WeldByPlace;
  std::vector<VertexId> Target; // the point that each point becomes; a point that stays becomes
                                // itself
  std::vector<VertexId> Kept;
};

}

double MostApart(const Box& box)
{
  return box.Empty() ? 0 : idTolerance * idTolerance * SquaredDistance(box.lo, box.hi);
}

MergedPoints MergePoints(const PartPoints& points, bool weldByPlace)
{
  return Merging(points, weldByPlace).Run();
}

}
