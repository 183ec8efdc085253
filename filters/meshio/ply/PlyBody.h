// SPDX-License-Identifier: BSD-3-Clause
// Reads the records of a PLY file's body, in the order of the file: the common part of the ASCII
// and the binary encoding. PlyReader decides which element is read when; here values become points
// and triangles. Part of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/PolygonFaces.h"
#include "filters/meshio/ply/PlyArrays.h"
#include "filters/meshio/ply/PlyHeader.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace kdstream
{

// Takes the corners of a polygon or strip one by one and appends its triangles. A polygon becomes a
// fan around its first corner; PolygonFaces cuts it again if a fan is wrong. Polygons of fewer than
// three corners are counted. A strip becomes triangles of alternating orientation; -1 begins a new
// strip, and degenerate triangles stay. Memory: the triangles.
class PlyFaceSink
{
public:
  enum class Kind
  {
    Polygon,
    Strip
  };

  PlyFaceSink(
    Kind kind, std::uint64_t vertexCount, std::vector<Triangle>& triangles, PolygonFaces& polygons)
    : FaceKind(kind)
    , VertexCount(vertexCount)
    , Triangles(triangles)
    , Polygons(polygons)
  {
  }

  void Begin() { this->Corners = 0; }
  // Ends a face. record: the number of the face's record.
  void End(std::uint64_t record)
  {
    if (this->FaceKind == Kind::Polygon && this->Corners < 3 && this->SmallFaces++ == 0)
    {
      this->FirstSmall = record;
    }
  }

  // Adds a corner. False if no vertex has this number; the face then stays unfinished.
  bool Add(std::int64_t index)
  {
    if (this->FaceKind == Kind::Strip && index == -1)
    {
      this->Corners = 0;
      return true;
    }
    if (!this->IsVertex(index))
    {
      return false;
    }
    const VertexId corner = static_cast<VertexId>(index);
    if (this->Corners < 2)
    {
      (this->Corners == 0 ? this->First : this->Second) = corner;
      ++this->Corners;
      return true;
    }
    ++this->Corners;
    if (this->FaceKind == Kind::Polygon)
    {
      this->Triangles.push_back({ this->First, this->Second, corner });
    }
    else
    {
      const bool reversed = this->Corners % 2 == 0;
      this->Triangles.push_back(reversed ? Triangle{ this->Second, this->First, corner }
                                         : Triangle{ this->First, this->Second, corner });
      this->First = this->Second;
    }
    this->Second = corner;
    return true;
  }

  bool IsVertex(std::int64_t index) const
  {
    return index >= 0 && static_cast<std::uint64_t>(index) < this->VertexCount;
  }
  Kind GetKind() const { return this->FaceKind; }
  std::uint64_t GetVertexCount() const { return this->VertexCount; }
  // The number of polygons with fewer than three corners, and the record number of the first.
  std::uint64_t GetSmallFaces() const { return this->SmallFaces; }
  std::uint64_t GetFirstSmall() const { return this->FirstSmall; }
  std::vector<Triangle>& GetTriangles() { return this->Triangles; }
  // Says that the `count` triangles from number `first` on, appended or still to be appended, are
  // those of one face.
  void EndFace(std::size_t first, std::size_t count)
  {
    if (this->FaceKind == Kind::Polygon)
    {
      this->Polygons.Add(first, count);
    }
  }

private:
  Kind FaceKind;
  std::uint64_t VertexCount;
  std::vector<Triangle>& Triangles;
  PolygonFaces& Polygons;
  std::uint64_t Corners = 0; // so far, of the polygon or of the last strip
  std::uint64_t SmallFaces = 0, FirstSmall = 0;
  VertexId First = 0;
  VertexId Second = 0;
};

// Reads consecutive records of one element. `first` is the number of the record at which the source
// stands. Errors of all methods: InvalidInput naming element and record ("vertex 17: …",
// "truncated: face 3 of 12 expected at byte 1234"), InputOutput.
class PlyBody
{
public:
  virtual ~PlyBody() = default;

  // `source` must outlive the body, and must stand where the header ends.
  static std::unique_ptr<PlyBody> Make(const PlyHeader& header, ByteSource& source);

  virtual Status SkipRecords(
    const PlyElement& element, std::uint64_t first, std::uint64_t count) = 0;

  // Appends `count` points and their arrays. `coordinates`: the numbers of the properties x, y, z,
  // which must not be lists. Returns whether all points are known to be finite.
  virtual Result<bool> ReadPoints(const PlyElement& element,
    const std::array<std::size_t, 3>& coordinates, std::uint64_t first, std::uint64_t count,
    std::vector<Vec3>& points, PlyArraySink& arrays) = 0;

  // Appends the triangles of `count` faces, and for each triangle the tuple of its face. `list`:
  // the number of the property with the corners, which is a list of whole numbers.
  virtual Status ReadFaces(const PlyElement& element, std::size_t list, std::uint64_t first,
    std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays) = 0;

  // The number of text lines with more values than the header names, among the points and faces
  // read since the last call. FirstLongLine: the first of these lines.
  std::uint64_t TakeLongLines() { return std::exchange(this->LongLines, 0); }
  const std::string& FirstLongLine() const { return this->FirstLong; }

protected:
  std::uint64_t LongLines = 0;
  std::string FirstLong;
};

std::unique_ptr<PlyBody> MakePlyAsciiBody(const PlyHeader& header, ByteSource& source);
std::unique_ptr<PlyBody> MakePlyBinaryBody(ByteSource& source, bool bigEndian);

// The value as an index or a count; nothing if it is not a whole number.
template <class T>
std::optional<std::int64_t> WholeNumber(T value)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    constexpr double most = 9007199254740992; // 2^53: up to here doubles hold all whole numbers
    if (!(std::abs(double(value)) <= most) || std::floor(value) != value)
    {
      return std::nullopt;
    }
  }
  return static_cast<std::int64_t>(value);
}

// Reads a word as a number of a property's type. An integer may be written as 3.0, as some programs
// write it.
template <class T>
NumberTextError ParsePlyNumber(std::string_view word, T& value)
{
  const NumberTextError error = ParseNumber(word, value);
  if constexpr (std::is_integral_v<T>)
  {
    double decimal = 0;
    const bool isDecimal =
      error == NumberTextError::NotANumber && ParseNumber(word, decimal) == NumberTextError::None;
    if (const auto whole = isDecimal ? WholeNumber(decimal) : std::nullopt)
    {
      value = static_cast<T>(*whole);
      return double(value) == decimal ? NumberTextError::None : NumberTextError::OutOfRange;
    }
  }
  return error;
}

// The place of one record, for messages.
struct PlyPlace
{
  const PlyElement& element;
  std::uint64_t record;
  std::uint64_t line = 0; // of a text file; 0 if there is none

  std::string Name() const; // "face 3 (line 17)"
  Error Bad(const std::string& what) const;
  Error Truncated(std::uint64_t byte) const;
  Error BadIndex(std::int64_t index, const PlyFaceSink& sink) const;
  Error BadListCount(const PlyProperty& property, std::int64_t count) const;
  // byte: the offset at which the first value of the list should be.
  Error ListPastEnd(const PlyProperty& property, std::int64_t count, std::uint64_t byte) const;
  Error RepeatsTooMuch() const;
};

}
