// SPDX-License-Identifier: BSD-3-Clause
// Points that make no sense, for the readers of all formats: those that are not finite are removed
// from a mesh, with the faces that use them (Tolerance.h); those in the other byte order are
// refused. Part of step "read".
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

// "whose y is nan". REQUIRES: a point that is not finite.
std::string WhatIsNotFinite(const Vec3& point);

// Refuses points that have sensible coordinates only in the other byte order: at least a quarter of
// those that are not 0 are smaller than 1e-9, larger than 1e12 or not finite, and in the other
// order nearly none is. type: of the coordinates in the file. Errors: InvalidInput.
Status CheckByteOrder(std::span<const Vec3> points, ScalarType type);
// The same of whole numbers of 32 bits, larger than 2^23.
Status CheckByteOrderOfIntegers(std::span<const Vec3> points, bool isSigned);

// Which of a file's points were dropped, and the new numbers of the others. Memory: some 2 MiB, and
// only after a point was dropped. Disk: a quarter of a byte for each point of the file.
class DroppedPoints
{
public:
  // folder: as ScratchTable's.
  explicit DroppedPoints(std::filesystem::path folder = {})
    : Folder(std::move(folder))
  {
  }

  bool Any() const { return this->Blocks.has_value(); }
  // REQUIRES: numbers that ascend. Errors: InputOutput.
  Status Add(std::uint64_t number);
  // The new number of a point, noVertex if it was dropped. Errors: InputOutput.
  Result<VertexId> NumberOf(VertexId number);

private:
  static constexpr std::uint64_t pointsOfBlock = 64;
  struct Block
  {
    std::uint64_t dropped = 0; // a bit a point
    std::uint64_t before = 0;  // that were dropped in earlier blocks
  };

  std::filesystem::path Folder;
  std::optional<ScratchTable<Block>> Blocks;
  std::uint64_t Count = 0;
};

// Drops the points from `begin` on that are not finite, with their tuples of point arrays, and adds
// them to `dropped`; first: the number of point `begin` in the file. tolerance: counts them, unless
// null. Errors: InputOutput.
Status DropPoints(
  Mesh& mesh, std::size_t begin, std::uint64_t first, DroppedPoints& dropped, Tolerance* tolerance);

// Gives the corners of the triangles from `begin` on their new numbers. Returns for each of these
// triangles whether it stays, because it uses no dropped point. Errors: InputOutput.
Result<std::vector<bool>> RenumberTriangles(Mesh& mesh, std::size_t begin, DroppedPoints& dropped);

// Drops the triangles from `begin` on that do not stay, with their tuples of cell arrays.
void KeepTriangles(Mesh& mesh, std::size_t begin, const std::vector<bool>& kept);

// The same of another list that has an element for each triangle.
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

// Drops the points of a whole mesh that are not finite, as DropPoints, and all triangles of faces
// that use them; counts both. begins: for each triangle, whether it is the first of its face;
// empty: each triangle is a face. Returns for each triangle whether it stays; empty if all do.
// Errors: InputOutput.
Result<std::vector<bool>> DropNotFinite(
  Mesh& mesh, const std::vector<bool>& begins, Tolerance& tolerance);

// The same, and of lists that have an element for each triangle.
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
