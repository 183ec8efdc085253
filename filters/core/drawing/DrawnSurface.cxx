// SPDX-License-Identifier: BSD-3-Clause
// A surface as renderers take it: see DrawnSurface.h.
#include "filters/core/drawing/DrawnSurface.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kdstream
{

DrawnSurface::DrawnSurface(SurfacePartList parts, const std::vector<PartNormals::Normals>& normals)
{
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    this->Points += parts[i]->own.size();
    this->Triangles += parts[i]->surface.triangles.size();
    this->All.push_back({ std::move(parts[i]), normals[i] });
  }
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
