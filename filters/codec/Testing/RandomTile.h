// SPDX-License-Identifier: BSD-3-Clause
// Random texture tiles, for tests of their codec.
#pragma once

#include "filters/codec/TextureTile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace kdstream::fixtures
{

// A grid of squares, each made of two triangles; in some triangles the corners are rotated.
inline std::vector<Triangle> TileGrid(std::uint32_t side)
{
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y < side; ++y)
  {
    for (std::uint32_t x = 0; x < side; ++x)
    {
      const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
      triangles.push_back({ a, a + 1, b + 1 });
      triangles.push_back({ a, b + 1, b });
    }
  }
  return triangles;
}

inline float Chance(std::mt19937& random, float most)
{
  return most * float(random() % 100000) / 100000;
}

// A tile with smooth coordinates, seams, and a few random coordinates.
inline TextureTile RandomTile(std::mt19937& random, const std::vector<Triangle>& triangles)
{
  const auto side = [&]() { return static_cast<std::uint32_t>(1 + random() % 4000); };
  TextureTile tile{ side(), side(), static_cast<TileImage>(1 + random() % 3),
    std::vector<std::uint8_t>(random() % 300, 7), {} };
  const float width = float(tile.width), height = float(tile.height);
  for (const Triangle& t : triangles)
  {
    const float seam = random() % 20 == 0 ? 0.5F : 0;
    auto& corners = tile.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const float place = float(t[k]) / 1000 + seam;
      corners[k] =
        random() % 50 == 0
          ? TileCoordinate{ Chance(random, width), Chance(random, height) }
          : TileCoordinate{ std::fmod(place, 1.0F) * width, std::fmod(3 * place, 1.0F) * height };
      for (float& number : corners[k])
      {
        number = std::nearbyint(number * tileSteps) / tileSteps;
      }
      corners[k] = { std::min(corners[k][0], width), std::min(corners[k][1], height) };
    }
  }
  return tile;
}

// Positions for the vertices of TileGrid, on a wavy surface.
inline std::vector<Vec3> TileGridPoints(std::uint32_t side)
{
  std::vector<Vec3> points;
  for (std::uint32_t y = 0; y <= side; ++y)
  {
    for (std::uint32_t x = 0; x <= side; ++x)
    {
      points.push_back({ 5000 + x / 8.0, y / 8.0, std::sin(x / 3.0) / 8 });
    }
  }
  return points;
}

// A planar tile of up to 6 charts that are turned anyhow; all corners lie in its picture.
inline TextureTile RandomPlanarTile(std::mt19937& random, const std::vector<Triangle>& triangles)
{
  TextureTile tile{ 4000, 4000, TileImage::Webp, std::vector<std::uint8_t>(20, 9), {} };
  tile.isPlanar = true;
  tile.planar.texels = 20 + double(random() % 1000) / 7;
  const auto number = [&](std::int32_t most)
  { return static_cast<std::int32_t>(random() % (2 * static_cast<unsigned>(most))) - most; };
  for (int i = 0; i < 6; ++i)
  {
    PlanarChart chart{ { 8 * 2000 + number(900), 8 * 2000 + number(900) }, {} };
    for (std::int32_t& of : chart.turn)
    {
      of = number(turnSteps / 2);
    }
    tile.planar.charts.push_back(chart);
  }
  std::uint32_t chart = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    chart = random() % 9 == 0 ? static_cast<std::uint32_t>(random() % 6) : chart;
    tile.planar.chartOf.push_back(chart);
  }
  return tile;
}

// An exact tile. All charts lie in a large picture, all corners in its first 1000 texels.
inline TextureTile RandomExactTile(std::mt19937& random, const std::vector<Triangle>& triangles)
{
  TextureTile tile{ 4000, 4000, TileImage::Webp, std::vector<std::uint8_t>(20, 9), {}, true };
  ExactTile& exact = tile.exact;
  exact.halvings = static_cast<std::uint8_t>(random() % 3);
  exact.sources = { { 3, 2000, 1000 }, { 0, 1000, 2000, { 1, 0, 0 }, { 0, -1, 1 }, { 2, 1 } } };
  for (int i = 0; i < 5; ++i)
  {
    exact.charts.push_back(
      { static_cast<std::uint32_t>(random() % 2), std::int64_t(random() % 1000), 500 });
  }
  exact.charts.push_back({ noTileSource, 17, 3999 });
  for (const Triangle& t : triangles)
  {
    exact.chartOf.push_back(static_cast<std::uint32_t>(random() % (random() % 9 == 0 ? 6 : 1)));
    auto& corners = exact.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const float place = float(t[k]) / 3000;
      corners[k] = { std::fmod(place, 1.0F), std::fmod(7 * place, 1.0F) };
      if (exact.chartOf.back() == 5 && random() % 3 == 0)
      {
        corners[k] = { std::numeric_limits<float>::quiet_NaN(), -0.0F };
      }
    }
  }
  return tile;
}

}
