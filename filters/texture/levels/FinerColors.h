// SPDX-License-Identifier: BSD-3-Clause
// Colours of a finer piece by places in space. Part of step "encode" of the pipeline picture:
// texture tiles.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Light.h"
#include "filters/core/pieces/Piece.h"
#include "filters/texture/Picture.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace kdstream
{

struct FinerTile
{
  Piece piece;
  TextureTile tile;
};

// Finds the triangle that is nearest to a place, by a grid of cubes. Keeps references.
class FinerColors
{
public:
  // picture: the tile's image, decoded. O(triangles) where they are of about one size.
  FinerColors(const FinerTile& finer, const Picture& picture);

  // At the nearest place of the surface: RGB in linear light, and alpha, 0-255. normal: of the
  // surface that is coloured, of any length; what faces the other way counts as farther. Of a piece
  // without triangles: black. near: a triangle where the search begins, or noNear; the one that is
  // found. Where the place is close to its inside, that is taken without a search: so the colour
  // depends on it a little.
  Color At(const Vec3& place, const Vec3& normal, std::uint32_t& near) const;
  static constexpr std::uint32_t noNear = 0xFFFFFFFF;

private:
  struct Ball // around a triangle
  {
    Vec3 middle{};
    double radius = 0;
    Vec3 normal{}; // of any length
  };
  struct Search
  {
    const Vec3& from;
    const Vec3& normal;
    double best, reach; // the squared distance, and its root
    std::uint32_t found;
  };
  using Cell = std::array<std::int64_t, 3>;

  const Vec3& PointOf(VertexId vertex) const { return this->Finer.piece.positions[vertex]; }
  bool CountCells();
  void MakeGrid();
  Cell CellOf(const Vec3& place) const;
  std::pair<Cell, Cell> CellsOf(std::uint32_t t) const; // the least and the greatest
  std::size_t NumberOf(std::int64_t x, std::int64_t y, std::int64_t z) const
  {
    return static_cast<std::size_t>((z * this->Counts[1] + y) * this->Counts[0] + x);
  }
  template <class Visit>
  void VisitCells(std::uint32_t t, const Visit& visit) const;
  void FindNearest(Search& search) const;
  void SearchShell(const Cell& middle, std::int64_t shell, Search& search) const;
  void SearchCell(std::size_t cell, Search& search) const;
  void Look(std::uint32_t t, Search& search) const;
  std::array<double, 2> CoordinatesOf(std::uint32_t t, const Vec3& place) const;
  std::optional<std::array<double, 2>> CloseAbove(
    std::uint32_t t, const Vec3& place, const Vec3& normal) const;
  Color ColorOn(std::uint32_t t, const std::array<double, 2>& coordinates) const;
  Color ColorAt(double x, double y) const;
  void AddTexel(std::size_t x, std::size_t y, double weight, Color& color) const;

  const FinerTile& Finer;
  const Picture& Image;
  const std::array<double, 256>& Linear;
  std::vector<Ball> Balls;
  Box Bounds;
  double Side = 0; // of a cell
  Cell Counts{};
  std::vector<std::uint32_t> First, Listed; // of each cell, its triangles
};

}
