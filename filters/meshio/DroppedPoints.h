// SPDX-License-Identifier: BSD-3-Clause
// Points that make no sense, for the readers of all formats. Points that are not finite are removed
// from a mesh, with the faces that use them (Tolerance.h). Files whose coordinates are in the other
// byte order are refused. Part of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/ScratchTable.h"
#include "filters/meshio/Tolerance.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Describes a point that is not finite: "whose y is nan". REQUIRES: a point that is not finite.
std::string WhatIsNotFinite(const Vec3& point);

// Refuses points whose coordinates make sense only in the other byte order. That is so if at least
// a quarter of the coordinates that are not 0 are smaller than 1e-9, larger than 1e12 or not
// finite, but nearly none are with the bytes swapped. type: the type of the coordinates in the
// file. Errors: InvalidInput.
Status CheckByteOrder(std::span<const Vec3> points, ScalarType type);
// The same check for whole numbers of 32 bits, where values above 2^23 are suspicious.
Status CheckByteOrderOfIntegers(std::span<const Vec3> points, bool isSigned);

// Records which of a file's points were dropped, and gives the others their new numbers. Memory:
// about 2 MiB, and only after a point was dropped. Disk: a quarter of a byte for each point of the
// file.
class DroppedPoints
{
public:
  // folder: see ScratchTable.
  explicit DroppedPoints(std::filesystem::path folder = {})
    : Folder(std::move(folder))
  {
  }

  bool Any() const { return this->Blocks.has_value(); }
  // Records that the point `number` was dropped. REQUIRES: ascending numbers. Errors: InputOutput.
  Status Add(std::uint64_t number);
  // Returns the new number of a point, or noVertex if it was dropped. Errors: InputOutput.
  Result<VertexId> NumberOf(VertexId number);

private:
  static constexpr std::uint64_t pointsOfBlock = 64;
  struct Block
  {
    std::uint64_t dropped = 0; // one bit a point
    std::uint64_t before = 0;  // number of points dropped in earlier blocks
  };

  std::filesystem::path Folder;
  std::optional<ScratchTable<Block>> Blocks;
  std::uint64_t Count = 0;
};

// Drops those points from `begin` on that are not finite, with their tuples of the point arrays,
// and adds their numbers to `dropped`. first: the number that point `begin` has in the file.
// tolerance: counts the dropped points, unless it is null. Errors: InputOutput.
Status DropPoints(
  Mesh& mesh, std::size_t begin, std::uint64_t first, DroppedPoints& dropped, Tolerance* tolerance);

// Renumbers the corners of the triangles from `begin` on. Returns for each of these triangles
// whether it stays: it does if it uses no dropped point. Errors: InputOutput.
Result<std::vector<bool>> RenumberTriangles(Mesh& mesh, std::size_t begin, DroppedPoints& dropped);

// Drops those triangles from `begin` on that do not stay, with their tuples of the cell arrays.
void KeepTriangles(Mesh& mesh, std::size_t begin, const std::vector<bool>& kept);

// Does the same for any list that has one element for each triangle.
template <class T>
void KeepOnly(std::vector<T>& list, const std::vector<bool>& kept)
{
  std::size_t left = 0;
  for (std::size_t i = 0; i < kept.size(); ++i)
  {
    list[left] = list[i];
    left += kept[i] ? 1 : 0;
  }
  list.resize(left);
}

// Drops the points of a whole mesh that are not finite, as DropPoints does, and all triangles of
// faces that use such points; counts both. begins: for each triangle, whether it is the first of
// its face; if empty, each triangle is a face. Returns for each triangle whether it stays; empty if
// all stay. Errors: InputOutput.
Result<std::vector<bool>> DropNotFinite(
  Mesh& mesh, const std::vector<bool>& begins, Tolerance& tolerance);

// The same, but also shortens `lists`, which have one element for each triangle.
template <class... Lists>
Status DropNotFiniteFaces(
  Mesh& mesh, const std::vector<bool>& begins, Tolerance& tolerance, Lists&... lists)
{
  const Result<std::vector<bool>> kept = DropNotFinite(mesh, begins, tolerance);
  KDSTREAM_TRY(kept);
  if (!kept->empty())
  {
    (KeepOnly(lists, *kept), ...);
  }
  return {};
}

}
