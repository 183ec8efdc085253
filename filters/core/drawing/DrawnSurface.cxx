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

using Glide = std::shared_ptr<const PartGlide>;

// Of a part that is drawn anew. Points of which nothing is known stand where they are.
Glide GlideOf(
  const DrawnSurface::Part& part, const DrawnSurface& before, const FormerPoints& former)
{
  PartGlide glide{ part.part->surface.points, *part.normals };
  for (std::size_t i = 0; i < former.size(); ++i)
  {
    if (former[i])
    {
      const DrawnSurface::Part& its = before.Parts()[former[i]->part];
      glide.points[i] = its.part->surface.points[former[i]->point];
      glide.normals[i] = (*its.normals)[former[i]->point];
    }
  }
  const bool moves = glide.points != part.part->surface.points || glide.normals != *part.normals;
  return moves ? std::make_shared<const PartGlide>(std::move(glide)) : nullptr;
}

// Of a part that has stayed: only its neighbours' triangles may light it otherwise.
Glide GlideOfNormals(const DrawnSurface::Part& part, const DrawnSurface& before)
{
  const auto& parts = before.Parts();
  const auto its = std::partition_point(parts.begin(), parts.end(),
    [&part](const DrawnSurface::Part& each) { return each.part->piece < part.part->piece; });
  const bool moves = its != parts.end() && its->part == part.part && its->normals != part.normals;
  return moves ? std::make_shared<const PartGlide>(
                   PartGlide{ part.part->surface.points, *its->normals })
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
  const DrawnSurface& before, const std::vector<FormerPoints>& former)
  : DrawnSurface(std::move(parts), normals)
{
  for (std::size_t i = 0; i < former.size(); ++i)
  {
    this->All[i].glide = former[i].empty() ? GlideOfNormals(this->All[i], before)
                                           : GlideOf(this->All[i], before, former[i]);
  }
}

bool DrawnSurface::HasGlides() const
{
  return std::any_of(
    this->All.begin(), this->All.end(), [](const Part& part) { return part.glide != nullptr; });
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
