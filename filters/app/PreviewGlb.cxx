// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/PreviewGlb.h"

#include "filters/app/ExtractMesh.h"
#include "filters/app/GlobePlace.h"
#include "filters/app/TileGlb.h"
#include "filters/app/TileMesh.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

Result<std::vector<std::uint8_t>> EncodePreviewGlb(const Store& store)
{
  const ModelDescription& model = store.Info();
  if (!model.HasLevels())
  {
    return std::vector<std::uint8_t>();
  }
  WantedMesh wanted;
  wanted.level = PreviewLevel(model);
  const Result<Mesh> mesh = ExtractMesh(store, wanted);
  KDSTREAM_TRY(mesh);
  if (mesh->triangles.empty())
  {
    return std::vector<std::uint8_t>();
  }
  const HomeView homeView = model.homeView.value_or(HomeView{});
  const Vec3 up = homeView.up;
  const Vec3 level = Minus(homeView.view, Times(up, Dot(homeView.view, up)));
  // A first view from nearly above tells nothing about the front.
  const Vec3 front = Length(level) > 0.1 ? Times(level, 1 / Length(level)) : FrontOf(up);
  Box around;
  double lowest = Dot(mesh->points[0], up);
  for (const Vec3& point : mesh->points)
  {
    around.Add(point);
    lowest = std::min(lowest, Dot(point, up));
  }
  const Vec3 sides = Minus(around.hi, around.lo);
  const double longest = std::max({ sides[0], sides[1], sides[2] });
  const Vec3 middle = Plus(around.lo, Times(sides, 0.5));
  TileFrame frame;
  frame.axes = { Cross(up, front), up, front };
  frame.origin = Plus(middle, Times(up, lowest - Dot(middle, up)));
  frame.scale = MetresOfUnit(model.unit).value_or(longest > 0 ? 1 / longest : 1);
  frame.copyright = model.credit;
  const auto bytes = EncodeTileGlb(WholeTileMesh(*mesh, true), frame, TileCompression::None);
  KDSTREAM_TRY(bytes);
  return std::vector<std::uint8_t>(bytes->begin(), bytes->end());
}

}
