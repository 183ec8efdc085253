// SPDX-License-Identifier: BSD-3-Clause
// Removes from a mesh points that are not finite, and faces that name them: see DroppedPoints.h.
#include "filters/meshio/DroppedPoints.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

namespace kdstream
{
namespace
{

// Tests without a branch for each point, because nearly always all points are finite.
bool AreFinite(std::span<const Vec3> points)
{
  constexpr double most = std::numeric_limits<double>::max();
  bool finite = true;
  for (const Vec3& point : points)
  {
    for (const double value : point)
    {
      finite &= std::abs(value) <= most;
    }
  }
  return finite;
}

// The value with its bytes in the other order.
template <class Number>
double Swapped(Number value)
{
  auto bytes = std::bit_cast<std::array<unsigned char, sizeof(Number)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  return double(std::bit_cast<Number>(bytes));
}

// Whether the value makes sense as a coordinate. Whole numbers up to 2^23 have a highest byte of 0
// or 255; swapped, all of them would have this in their last byte.
template <class Number>
bool IsSensible(double value)
{
  constexpr double least = 1e-9, most = 1e12, mostWhole = 0x1p23;
  return std::is_integral_v<Number>
           ? std::abs(value) <= mostWhole
           : value == 0 || (std::abs(value) >= least && std::abs(value) <= most);
}

std::string ShortText(double value)
{
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

// From the arrays of one association, keeps the tuples begin + i for which keeps(i) is true.
template <class Keeps>
void KeepTuples(Mesh& mesh, AttributeAssociation association, std::size_t begin, const Keeps& keeps)
{
  for (Attribute& attribute : mesh.attributes)
  {
    if (attribute.association != association)
    {
      continue;
    }
    const std::size_t size = attribute.TupleSize(), count = attribute.TupleCount();
    std::uint8_t* to = attribute.values.data() + begin * size;
    for (std::size_t i = begin; i < count; ++i)
    {
      if (keeps(i - begin))
      {
        std::memmove(to, attribute.values.data() + i * size, size);
        to += size;
      }
    }
    attribute.values.resize(static_cast<std::size_t>(to - attribute.values.data()));
  }
}

template <class Number>
Status CheckByteOrderOf(std::span<const Vec3> points)
{
  constexpr std::size_t fewest = 9; // three points
  std::size_t numbers = 0, sensible = 0, swappedSensible = 0;
  std::string example;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double value = points[i][k];
      if (value == 0)
      {
        continue;
      }
      const double swapped = Swapped(static_cast<Number>(value));
      ++numbers;
      sensible += IsSensible<Number>(value) ? 1 : 0;
      swappedSensible += IsSensible<Number>(swapped) ? 1 : 0;
      if (example.empty() && !IsSensible<Number>(value) && IsSensible<Number>(swapped))
      {
        example = std::string(1, "xyz"[k]) + " of point " + std::to_string(i) + " is " +
                  ShortText(value) + ", and with its bytes swapped " + ShortText(swapped);
      }
    }
  }
  const bool isSwapped = numbers >= fewest && 4 * (numbers - sensible) >= numbers &&
                         100 * (numbers - swappedSensible) <= numbers;
  return isSwapped
           ? BadInput(
               "its numbers seem to have the opposite of the byte order that it states: " + example,
               Remedy::Repair)
           : Status();
}

}

Status CheckByteOrder(std::span<const Vec3> points, ScalarType type)
{
  return type == ScalarType::Float32 ? CheckByteOrderOf<float>(points)
                                     : CheckByteOrderOf<double>(points);
}

Status CheckByteOrderOfIntegers(std::span<const Vec3> points, bool isSigned)
{
  return isSigned ? CheckByteOrderOf<std::int32_t>(points)
                  : CheckByteOrderOf<std::uint32_t>(points);
}

std::string WhatIsNotFinite(const Vec3& point)
{
  const auto* const bad =
    std::find_if(point.begin(), point.end(), [](double v) { return !std::isfinite(v); });
  return std::string("whose ") + "xyz"[bad - point.begin()] + " is " +
         (std::isnan(*bad) ? "nan"
           : *bad > 0      ? "inf"
                           : "-inf");
}

Status DroppedPoints::Add(std::uint64_t number)
{
  if (!this->Blocks)
  {
    this->Blocks.emplace(this->Folder);
  }
  const std::uint64_t block = number / pointsOfBlock;
  while (this->Blocks->Size() <= block)
  {
    KDSTREAM_TRY(this->Blocks->Append({ 0, this->Count }));
  }
  Result<Block> changed = this->Blocks->Get(block);
  KDSTREAM_TRY(changed);
  changed->dropped |= std::uint64_t{ 1 } << number % pointsOfBlock;
  ++this->Count;
  return this->Blocks->Set(block, *changed);
}

Result<VertexId> DroppedPoints::NumberOf(VertexId number)
{
  const std::uint64_t block = number / pointsOfBlock;
  if (!this->Blocks || block >= this->Blocks->Size())
  {
    return static_cast<VertexId>(number - this->Count);
  }
  const Result<Block> found = this->Blocks->Get(block);
  KDSTREAM_TRY(found);
  const std::uint64_t bit = std::uint64_t{ 1 } << number % pointsOfBlock;
  const auto before =
    found->before + static_cast<std::uint64_t>(std::popcount(found->dropped & (bit - 1)));
  return (found->dropped & bit) != 0 ? noVertex : static_cast<VertexId>(number - before);
}

Status DropPoints(
  Mesh& mesh, std::size_t begin, std::uint64_t first, DroppedPoints& dropped, Tolerance* tolerance)
{
  if (AreFinite(std::span(mesh.points).subspan(begin)))
  {
    return {};
  }
  const auto from = mesh.points.begin() + static_cast<std::ptrdiff_t>(begin);
  std::vector<bool> finite;
  finite.reserve(mesh.points.size() - begin);
  for (auto point = from; point != mesh.points.end(); ++point)
  {
    finite.push_back(IsFinite(*point));
    if (!finite.back())
    {
      const std::uint64_t number = first + finite.size() - 1;
      KDSTREAM_TRY(dropped.Add(number));
      if (tolerance)
      {
        tolerance->Count(Lapse::PointNotFinite, 1,
          tolerance->Of(Lapse::PointNotFinite) == 0
            ? "vertex " + std::to_string(number) + ", " + WhatIsNotFinite(*point)
            : std::string());
      }
    }
  }
  KeepTuples(mesh, AttributeAssociation::Point, begin, [&](std::size_t i) { return finite[i]; });
  mesh.points.erase(
    std::remove_if(from, mesh.points.end(), [](const Vec3& point) { return !IsFinite(point); }),
    mesh.points.end());
  return {};
}

Result<std::vector<bool>> RenumberTriangles(Mesh& mesh, std::size_t begin, DroppedPoints& dropped)
{
  std::vector<bool> kept(mesh.triangles.size() - begin, true);
  for (std::size_t i = 0; i < kept.size(); ++i)
  {
    for (VertexId& corner : mesh.triangles[begin + i])
    {
      const Result<VertexId> number = dropped.NumberOf(corner);
      KDSTREAM_TRY(number);
      corner = *number;
      kept[i] = kept[i] && corner != noVertex;
    }
  }
  return kept;
}

void KeepTriangles(Mesh& mesh, std::size_t begin, const std::vector<bool>& kept)
{
  KeepTuples(mesh, AttributeAssociation::Cell, begin, [&](std::size_t i) { return kept[i]; });
  std::size_t left = begin;
  for (std::size_t i = 0; i < kept.size(); ++i)
  {
    mesh.triangles[left] = mesh.triangles[begin + i];
    left += kept[i] ? 1 : 0;
  }
  mesh.triangles.resize(left);
}

Result<std::vector<bool>> DropNotFinite(
  Mesh& mesh, const std::vector<bool>& begins, Tolerance& tolerance)
{
  DroppedPoints dropped;
  KDSTREAM_TRY(DropPoints(mesh, 0, 0, dropped, &tolerance));
  if (!dropped.Any())
  {
    return std::vector<bool>();
  }
  std::string first;
  for (std::size_t i = 0; i < mesh.triangles.size() && first.empty(); ++i)
  {
    for (const VertexId corner : mesh.triangles[i])
    {
      const Result<VertexId> number = dropped.NumberOf(corner);
      KDSTREAM_TRY(number);
      first = *number == noVertex ? "one that names vertex " + std::to_string(corner) : first;
    }
  }
  Result<std::vector<bool>> kept = RenumberTriangles(mesh, 0, dropped);
  KDSTREAM_TRY(kept);
  std::uint64_t faces = 0;
  for (std::size_t begin = 0; begin < kept->size();)
  {
    std::size_t end = begin + 1;
    while (end < begins.size() && !begins[end])
    {
      ++end;
    }
    const auto from = kept->begin() + static_cast<std::ptrdiff_t>(begin);
    const auto to = kept->begin() + static_cast<std::ptrdiff_t>(end);
    if (std::find(from, to, false) != to)
    {
      std::fill(from, to, false);
      ++faces;
    }
    begin = end;
  }
  tolerance.Count(Lapse::FaceOfDroppedPoint, faces, first);
  KeepTriangles(mesh, 0, *kept);
  return kept;
}

}
