// SPDX-License-Identifier: BSD-3-Clause
// Cuts polygons again where a fan of triangles is wrong. Readers first append each polygon as a
// fan, because this needs no positions of vertices. Part of step "read".
#pragma once

#include "filters/core/CutPolygon.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// Replaces the n - 2 triangles of a fan by the same number of triangles `cut`. `fan` has the values
// of its corners, in the order of a fan around corner 0.
template <class Value>
void ScatterToTriangles(std::span<std::array<Value, 3>> fan, std::span<const Triangle> cut)
{
  std::vector<Value> corners{ fan[0][0], fan[0][1] };
  for (const std::array<Value, 3>& triangle : fan)
  {
    corners.push_back(triangle[2]);
  }
  for (std::size_t i = 0; i < fan.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      fan[i][k] = corners[cut[i][k]];
    }
  }
}

// Remembers which triangles belong to polygons. Memory: 16 bytes for each polygon of more than
// three corners added since the last cut.
class PolygonFaces
{
public:
  // Adds a polygon whose fan is the `count` triangles from number `first` on.
  void Add(std::size_t first, std::size_t count)
  {
    if (count > 1)
    {
      this->Fans.push_back({ first, count });
    }
  }
  bool Empty() const { return this->Fans.empty(); }

  // Cuts the polygons that were added, and forgets them. Calls changed(first, cut) for each polygon
  // that needs another cut than a fan. placeOf(vertex) returns a Result<Vec3>. Errors: those of
  // placeOf.
  template <class PlaceOf, class Changed>
  Status Cut(std::span<const Triangle> triangles, const PlaceOf& placeOf, const Changed& changed)
  {
    for (const Fan& fan : this->Fans)
    {
      const auto run = triangles.subspan(fan.first, fan.count);
      this->Corners.clear();
      for (std::size_t i = 0; i < fan.count + 2; ++i)
      {
        const auto place = placeOf(i < 2 ? run[0][i] : run[i - 2][2]);
        KDSTREAM_TRY(place);
        this->Corners.push_back(*place);
      }
      const std::span<const Triangle> cut = this->Cutter.Cut(this->Corners);
      if (!this->Cutter.IsFan())
      {
        changed(fan.first, cut);
      }
    }
    this->Fans.clear();
    return {};
  }
  // The same for a list that has only triangles and no further values of corners.
  template <class PlaceOf>
  Status Cut(std::vector<Triangle>& triangles, const PlaceOf& placeOf)
  {
    return this->Cut(triangles, placeOf,
      [&](std::size_t first, std::span<const Triangle> cut)
      { ScatterToTriangles(std::span(triangles).subspan(first, cut.size()), cut); });
  }

private:
  struct Fan
  {
    std::size_t first = 0, count = 0;
  };

  std::vector<Fan> Fans;
  std::vector<Vec3> Corners;
  PolygonCutter Cutter;
};

}
