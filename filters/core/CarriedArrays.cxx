// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/CarriedArrays.h"

#include "filters/core/ScalarSums.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace kdstream
{
namespace
{

template <class Sum>
std::vector<Sum> SumsOfGroups(const Attribute& array, std::size_t component,
  std::span<const VertexId> groupOf, std::size_t count)
{
  std::vector<Sum> sums(count);
  for (std::size_t i = 0; i < groupOf.size(); ++i)
  {
    if (groupOf[i] != noVertex)
    {
      sums[groupOf[i]].Add(array, i, component);
    }
  }
  return sums;
}

Attribute MeansOf(const Attribute& array, std::span<const VertexId> groupOf, std::size_t count)
{
  Attribute means{ array.Info(), {} };
  if (array.components == 1 && HoldsClasses(array))
  {
    for (const ClassVotes& votes : SumsOfGroups<ClassVotes>(array, 0, groupOf, count))
    {
      votes.AppendMean(means);
    }
    return means;
  }
  means.values.resize(count * means.TupleSize());
  for (std::size_t k = 0; k < array.components; ++k)
  {
    const auto sums = SumsOfGroups<ScalarSum>(array, k, groupOf, count);
    for (std::size_t group = 0; group < count; ++group)
    {
      means.Set(group, k, sums[group].Mean());
    }
  }
  return means;
}

Vec3 CentreOf(std::span<const Vec3> points, const Triangle& t)
{
  Vec3 centre{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    centre[k] = (points[t[0]][k] + points[t[1]][k] + points[t[2]][k]) / 3;
  }
  return centre;
}

// For each point of a coarser mesh, the triangles around it.
class TrianglesAround
{
public:
  explicit TrianglesAround(const CoarserSurface& coarser)
    : Coarser(coarser)
    , Begin(coarser.points.size() + 1, 0)
    , Triangles(3 * coarser.triangles.size())
  {
    for (const Triangle& t : coarser.triangles)
    {
      for (const VertexId v : t)
      {
        ++this->Begin[v + 1];
      }
    }
    std::partial_sum(this->Begin.begin(), this->Begin.end(), this->Begin.begin());
    std::vector<std::size_t> next(this->Begin.begin(), this->Begin.end() - 1);
    for (std::size_t t = 0; t < coarser.triangles.size(); ++t)
    {
      for (const VertexId v : coarser.triangles[t])
      {
        this->Triangles[next[v]++] = static_cast<VertexId>(t);
      }
    }
  }

  // The coarser triangle to which a finer one belongs. image: the clusters of the finer triangle's
  // points; centre: its centre.
  VertexId OwnerOf(Triangle image, const Vec3& centre) const
  {
    std::rotate(image.begin(), std::min_element(image.begin(), image.end()), image.end());
    const auto& all = this->Coarser.triangles;
    const auto found = std::lower_bound(all.begin(), all.end(), image);
    if (found != all.end() && *found == image)
    {
      return static_cast<VertexId>(found - all.begin());
    }
    // Most common corners first, then the nearest, then the first: the smallest tuple is the best.
    auto best = std::tuple(0, std::numeric_limits<double>::infinity(), noVertex);
    for (const VertexId cluster : image)
    {
      for (std::size_t i = this->Begin[cluster]; i < this->Begin[cluster + 1]; ++i)
      {
        const Triangle& t = all[this->Triangles[i]];
        const auto isShared = [&](VertexId v)
        { return std::find(image.begin(), image.end(), v) != image.end(); };
        const auto shared = static_cast<int>(std::count_if(t.begin(), t.end(), isShared));
        const double apart = SquaredDistance(CentreOf(this->Coarser.points, t), centre);
        best = std::min(best, std::tuple(-shared, apart, this->Triangles[i]));
      }
    }
    return std::get<2>(best);
  }

private:
  const CoarserSurface& Coarser;
  std::vector<std::size_t> Begin;
  std::vector<VertexId> Triangles;
};

}

std::vector<Attribute> MeansOfGroups(
  std::span<const Attribute> arrays, std::span<const VertexId> groupOf, std::size_t count)
{
  std::vector<Attribute> means;
  for (const Attribute& array : arrays)
  {
    means.push_back(MeansOf(array, groupOf, count));
  }
  return means;
}

std::vector<Attribute> CarryCells(std::span<const Attribute> arrays, const Mesh& mesh,
  std::span<const VertexId> clusterOf, const CoarserSurface& coarser, const Execution& execution)
{
  if (arrays.empty())
  {
    return {};
  }
  const TrianglesAround around(coarser);
  std::vector<VertexId> owner(mesh.triangles.size());
  execution.parallelFor(owner.size(), 1 << 12,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        const Triangle& t = mesh.triangles[i];
        owner[i] = around.OwnerOf(
          { clusterOf[t[0]], clusterOf[t[1]], clusterOf[t[2]] }, CentreOf(mesh.points, t));
      }
    });
  std::vector<Attribute> carried = MeansOfGroups(arrays, owner, coarser.triangles.size());

  std::vector<bool> hasOwn(coarser.triangles.size(), false);
  std::vector<VertexId> firstOf(coarser.points.size(), noVertex); // triangle with a point there
  for (std::size_t i = owner.size(); i-- > 0;)
  {
    if (owner[i] != noVertex)
    {
      hasOwn[owner[i]] = true;
    }
    for (const VertexId v : mesh.triangles[i])
    {
      firstOf[clusterOf[v]] = static_cast<VertexId>(i);
    }
  }
  for (std::size_t t = 0; t < hasOwn.size(); ++t)
  {
    const VertexId from = firstOf[coarser.triangles[t][0]];
    for (std::size_t k = 0; k < carried.size() && !hasOwn[t] && from != noVertex; ++k)
    {
      const std::size_t size = arrays[k].TupleSize();
      std::copy_n(arrays[k].values.begin() + std::ptrdiff_t(from * size), size,
        carried[k].values.begin() + std::ptrdiff_t(t * size));
    }
  }
  return carried;
}

}
