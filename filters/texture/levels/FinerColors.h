// SPDX-License-Identifier: BSD-3-Clause
// Colours of a finer piece by places in space. Part of step "encode" of the pipeline picture:
// texture tiles.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Light.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/texture/Picture.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace kdstream
{

struct FinerTile
{
  Piece piece;
  TextureTile tile;
};

// As ByteOfLinear, but where a value is within 2^-15 of the next byte's: by a table. REQUIRES: a
// number.
std::uint8_t QuickByteOfLinear(double value);

// Half as wide and high, or a texel more: means in linear light.
Picture HalfOf(const Picture& picture);

// A finer piece, prepared for samples: finds the triangle that is nearest to a place, by walking
// over edges from one that is near, or by a grid of cubes. Any number of threads.
class FinerColors
{
public:
  // O(triangles log triangles) where they are of about one size.
  explicit FinerColors(FinerTile finer);

  const FinerTile& Of() const { return this->Finer; }

  // The tile's image, halved this number of times.
  struct Shown
  {
    const Picture* picture = nullptr;
    double scale = 1; // of the image, to the tile's
  };
  // Decoded when it is asked for first, and then kept. oneLarge: held from then on, by an image of
  // more than 2 million texels; null: not. Errors: Damaged where the image cannot be decoded, or
  // has another size than the tile states.
  Result<Shown> HalvedBy(unsigned halvings, std::mutex* oneLarge) const;

  // About, with the image.
  std::size_t Bytes() const;
  bool IsLarge() const;

  // At the nearest place of the surface: RGB in linear light, and alpha, 0-255. normal: of the
  // surface that is coloured, of length 1 or 0; what faces elsewhere counts as farther. Of a piece
  // without triangles: black. near: a triangle where the search begins, or noNear; the one that is
  // found. A triangle a few edges from there is taken where the place is close to its inside,
  // without looking for a nearer one: so the colour depends on `near` a little.
  Color At(const Shown& shown, const Vec3& place, const Vec3& normal, std::uint32_t& near) const;
  static constexpr std::uint32_t noNear = 0xFFFFFFFF;

private:
  struct Ball // around a triangle
  {
    Vec3 middle{};
    double radius = 0;
    Vec3 normal{};         // of length 1; 0 of a triangle without area
    Vec3 first{}, third{}; // what is added to CoordinatesOf along a way; 0 without area
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
  void FindNeighbours();
  bool WalkFrom(std::uint32_t& t, const Vec3& place, const Vec3& normal,
    std::array<double, 2>& coordinates) const;
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
  bool IsClose(std::uint32_t t, const Vec3& place, const Vec3& normal) const;
  Color ColorOn(
    const Shown& shown, std::uint32_t t, const std::array<double, 2>& coordinates) const;
  Color ColorAt(const Picture& picture, double x, double y) const;
  void AddTexel(
    const Picture& picture, std::size_t x, std::size_t y, double weight, Color& color) const;

  const FinerTile Finer;
  const std::array<double, 256>& Linear;
  std::vector<Ball> Balls;
  std::vector<std::array<std::uint32_t, 3>> Beside; // over the edge from each corner to the next
  Box Bounds;
  double Side = 0; // of a cell
  Cell Counts{};
  std::vector<std::uint32_t> First, Listed; // of each cell, its triangles
  mutable std::mutex Decoding;
  mutable std::map<unsigned, Picture> Pictures;  // by halvings
  mutable std::unique_lock<std::mutex> OneLarge; // of a large image
};

}
