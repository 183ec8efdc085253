// SPDX-License-Identifier: BSD-3-Clause
// A surface as renderers take it: see DrawnSurface.h.
#include "filters/core/drawing/DrawnSurface.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kdstream
{
namespace
{

using Geomorph = std::shared_ptr<const PartGeomorph>;

// The geomorph of a part that is rebuilt. Points without a known parent do not move.
Geomorph GeomorphOf(
  const DrawnSurface::Part& part, const DrawnSurface& before, const ParentPoints& parents)
{
  PartGeomorph geomorph{ part.part->surface.points, *part.normals };
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    if (parents[i])
    {
      const DrawnSurface::Part& its = before.Parts()[parents[i]->part];
      geomorph.points[i] = its.part->surface.points[parents[i]->point];
      geomorph.normals[i] = (*its.normals)[parents[i]->point];
    }
  }
  const bool moves =
    geomorph.points != part.part->surface.points || geomorph.normals != *part.normals;
  return moves ? std::make_shared<const PartGeomorph>(std::move(geomorph)) : nullptr;
}

// The geomorph of a part that is not rebuilt. Only its normals change, because triangles beside it
// have changed.
Geomorph GeomorphOfNormals(const DrawnSurface::Part& part, const DrawnSurface& before)
{
  const auto& parts = before.Parts();
  const auto its = std::partition_point(parts.begin(), parts.end(),
    [&part](const DrawnSurface::Part& each) { return each.part->piece < part.part->piece; });
  const bool moves = its != parts.end() && its->part == part.part && its->normals != part.normals;
  return moves ? std::make_shared<const PartGeomorph>(
                   PartGeomorph{ part.part->surface.points, *its->normals })
               : nullptr;
}

}

DrawnSurface::DrawnSurface(SurfacePartList parts, const std::vector<PartNormals::Normals>& normals)
{
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    this->Points += parts[i]->own.size();
    this->Triangles += parts[i]->surface.triangles.size();
    this->All.push_back({ std::move(parts[i]), normals[i], nullptr });
  }
}

DrawnSurface::DrawnSurface(SurfacePartList parts, const std::vector<PartNormals::Normals>& normals,
  const DrawnSurface& before, const std::vector<ParentPoints>& parents)
  : DrawnSurface(std::move(parts), normals)
{
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    this->All[i].geomorph = parents[i].empty() ? GeomorphOfNormals(this->All[i], before)
                                               : GeomorphOf(this->All[i], before, parents[i]);
  }
}

bool DrawnSurface::HasGeomorphs() const
{
  return std::any_of(
    this->All.begin(), this->All.end(), [](const Part& part) { return part.geomorph != nullptr; });
}

DrawnSurface::DrawnSurface(Surface whole)
{
  const bool isSound = std::all_of(whole.triangles.begin(), whole.triangles.end(),
    [&whole](const Triangle& t) {
      return std::max({ t[0], t[1], t[2] }) < whole.points.size();
    });
  auto part = std::make_shared<SurfacePart>();
  part->own.resize(whole.points.size());
  std::iota(part->own.begin(), part->own.end(), 0U);
  part->surface = std::move(whole);
  PartNormals normals;
  if (isSound)
  {
    normals.GoTo({ part });
  }
  const auto none = std::make_shared<const std::vector<Vec3>>(part->own.size(), Vec3{});
  *this =
    DrawnSurface({ part }, isSound ? normals.Of() : std::vector<PartNormals::Normals>{ none });
}

const Surface& DrawnSurface::Whole() const
{
  if (this->All.size() == 1)
  {
    return this->All.front().part->surface;
  }
  if (!this->Merged)
  {
    SurfacePartList parts;
    std::transform(this->All.begin(), this->All.end(), std::back_inserter(parts),
      [](const Part& part) { return part.part; });
    this->Merged = MergeParts(parts);
  }
  return *this->Merged;
}

}
