// SPDX-License-Identifier: BSD-3-Clause
// Looks up the colours of a finer piece at places in space. Part of step "encode" of the pipeline
// picture: texture tiles.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Light.h"
#include "filters/core/Result.h"
#include "filters/core/VectorMath.h"
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

// As ByteOfLinear, but by a table. The result can differ only if the value is within 2^-15 of the
// border between two bytes. REQUIRES: value is not NaN.
std::uint8_t QuickByteOfLinear(double value);

// Halves width and height, rounded up. Texels are means in linear light.
Picture HalfOf(const Picture& picture);

// A finer piece, prepared for samples. Finds the triangle that is nearest to a place, by walking
// over edges from a triangle nearby, or by a grid of cubes. Any number of threads may use it.
class FinerColors
{
public:
  // O(triangles log triangles) if triangles have about the same size.
  explicit FinerColors(FinerTile finer);

  const FinerTile& Of() const { return this->Finer; }

  // The tile's image, halved this number of times.
  struct Shown
  {
    const Picture* picture = nullptr;
    double scale = 1; // factor from the tile's texels to the picture's
  };
  // The image is decoded at the first call, and then kept. oneLarge: an image of more than 2
  // million texels locks it from then on; null: no lock. Errors: Damaged if the image cannot be
  // decoded, or has another size than the tile states.
  Result<Shown> HalvedBy(unsigned halvings, std::mutex* oneLarge) const;

  // The approximate memory, with the image.
  std::size_t Bytes() const;
  bool IsLarge() const;

  // The colour at the nearest place of the surface: RGB in linear light, and alpha, 0-255; black if
  // the piece has no triangles. normal: of the surface that gets the colour, of length 1 or 0;
  // triangles that face elsewhere count as farther away. near: the triangle where the search
  // begins, or noNear; afterwards the triangle that was found. If the place is close to the inside
  // of a triangle a few edges away from `near`, this triangle is taken, even if another one is
  // nearer. So the colour depends on `near` a little. squared: afterwards the square of the
  // distance, more where the triangle faces elsewhere; infinite without triangles.
  Color At(const Shown& shown, const Vec3& place, const Vec3& normal, std::uint32_t& near,
    double& squared) const;
  static constexpr std::uint32_t noNear = 0xFFFFFFFF;

private:
  struct Ball // around a triangle
  {
    Vec3 middle{};
    double radius = 0;
    Vec3 normal{};         // of length 1; 0 if the triangle has no area
    Vec3 first{}, third{}; // gradients of CoordinatesOf; 0 without area
  };
  struct Search
  {
    const Vec3& from;
    const Vec3& normal;
    double best, reach; // squared distance of the best, and its root
    std::uint32_t found;
  };
  using Cell = std::array<std::int64_t, 3>;

  const Vec3& PointOf(VertexId vertex) const { return this->Finer.piece.positions[vertex]; }
  bool CountCells();
  void MakeGrid();
  void FindNeighbours();
  bool WalkFrom(std::uint32_t& t, const Vec3& place, const Vec3& normal,
    std::array<double, 2>& coordinates) const;
  double AboveOf(std::uint32_t t, const Vec3& place) const
  {
    return Dot(this->Balls[t].normal, Minus(place, this->Balls[t].middle));
  }
  Cell CellOf(const Vec3& place) const;
  std::pair<Cell, Cell> CellsOf(std::uint32_t t) const; // the lowest and the highest
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
  std::vector<std::array<std::uint32_t, 3>> Beside; // neighbour over each corner's edge to the next
  Box Bounds;
  double Side = 0; // of a grid cell
  Cell Counts{};
  std::vector<std::uint32_t> First, Listed; // the triangles of each cell
  mutable std::mutex Decoding;
  mutable std::map<unsigned, Picture> Pictures;  // by number of halvings
  mutable std::unique_lock<std::mutex> OneLarge; // locked for a large image
};

}
