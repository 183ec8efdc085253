// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/PolyDataMesh.h"

#include "filters/adapter/PolyDataCells.h"
#include "filters/core/CutPolygon.h"
#include "filters/core/VectorMath.h"

#include <vtkArrayDispatch.h>
#include <vtkCellArray.h>
#include <vtkDataArrayRange.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkPoints.h>
#include <vtkVariant.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

namespace kdstream
{
namespace
{

using Corners = std::span<const vtkIdType>;

void AddVertices(Corners points, std::vector<Triangle>& elements)
{
  for (const vtkIdType point : points)
  {
    const auto a = static_cast<VertexId>(point);
    elements.push_back({ a, a, a });
  }
}

void AddSegments(Corners points, std::vector<Triangle>& elements)
{
  for (std::size_t i = 1; i < points.size(); ++i)
  {
    const auto a = static_cast<VertexId>(points[i - 1]), b = static_cast<VertexId>(points[i]);
    elements.push_back({ a, b, b });
  }
}

void AddStrip(Corners points, std::vector<Triangle>& elements)
{
  for (std::size_t i = 2; i < points.size(); ++i)
  {
    const auto a = static_cast<VertexId>(points[i - 2]), b = static_cast<VertexId>(points[i - 1]);
    const auto c = static_cast<VertexId>(points[i]);
    elements.push_back(i % 2 == 0 ? Triangle{ a, b, c } : Triangle{ b, a, c });
  }
}

// Appends the triangles of polygons (CutPolygon.h).
class AddPolygons
{
public:
  explicit AddPolygons(vtkPoints* points)
    : Points(points)
  {
  }

  void operator()(Corners polygon, std::vector<Triangle>& elements)
  {
    this->Places.resize(polygon.size());
    for (std::size_t i = 0; i < polygon.size() && polygon.size() > 3; ++i)
    {
      this->Points->GetPoint(polygon[i], this->Places[i].data());
    }
    for (const Triangle& t : this->Cutter.Cut(this->Places))
    {
      elements.push_back({ static_cast<VertexId>(polygon[t[0]]),
        static_cast<VertexId>(polygon[t[1]]), static_cast<VertexId>(polygon[t[2]]) });
    }
  }

private:
  vtkPoints* Points;
  std::vector<Vec3> Places;
  PolygonCutter Cutter;
};

// Appends the elements of the cells of one array. firstCell: the id of the array's first cell in
// the input.
template <class Add>
Status ReadCells(vtkCellArray* cells, vtkIdType firstCell, vtkIdType pointCount, Add&& add,
  PolyDataElements& elements)
{
  return ForEachCell(cells, firstCell, pointCount,
    [&](vtkIdType cell, Corners corners)
    {
      add(corners, elements.corners);
      elements.cells.resize(elements.corners.size(), cell);
    });
}

// Copies points, beginning with `first`; contiguous ones as a block.
void CopyPoints(vtkPoints& points, std::size_t first, std::span<Vec3> copies)
{
  const auto copy = [&](const auto* coordinates)
  {
    coordinates += 3 * first;
    for (Vec3& p : copies)
    {
      p = { double(coordinates[0]), double(coordinates[1]), double(coordinates[2]) };
      coordinates += 3;
    }
  };
  if (auto* const floats = vtkFloatArray::SafeDownCast(points.GetData()))
  {
    copy(floats->GetPointer(0));
  }
  else if (auto* const doubles = vtkDoubleArray::SafeDownCast(points.GetData()))
  {
    copy(doubles->GetPointer(0));
  }
  else
  {
    for (std::size_t i = 0; i < copies.size(); ++i)
    {
      points.GetPoint(static_cast<vtkIdType>(first + i), copies[i].data());
    }
  }
}

// Appends the values of an array to `labels`, up to the first value that is not a whole number.
// Reading each value as a vtkVariant would take 5 times as long as a loop over the array's own
// type.
struct LabelReader
{
  std::vector<std::int64_t>& labels;

  template <class Array>
  void operator()(Array* array)
  {
    for (const vtk::GetAPIType<Array> value : vtk::DataArrayValueRange<1>(array))
    {
      if (!this->Append(value))
      {
        return;
      }
    }
  }

  // Reads an array whose type VTK's dispatch does not know. Bits are read as doubles, because the
  // vtkVariant of a vtkBitArray's value is always 0 as a number.
  void ReadAny(vtkDataArray& array)
  {
    const int type = array.GetDataType();
    const bool areDoubles =
      type == VTK_FLOAT || type == VTK_DOUBLE || type == VTK_BIT; // exact ones
    for (vtkIdType i = 0; i < array.GetNumberOfTuples(); ++i)
    {
      if (!(areDoubles ? this->Append(array.GetComponent(i, 0))
                       : this->Append(array.GetVariantValue(i).ToTypeInt64())))
      {
        return;
      }
    }
  }

  template <class Value>
  bool Append(Value value)
  {
    if constexpr (std::is_floating_point_v<Value>)
    {
      constexpr Value exact = 9007199254740992; // 2^53
      if (!(std::abs(value) <= exact) || std::floor(value) != value)
      {
        return false;
      }
    }
    this->labels.push_back(static_cast<std::int64_t>(value));
    return true;
  }
};

}

Result<std::vector<Vec3>> ReadPoints(vtkPolyData& input, const Execution& execution, bool any)
{
  const auto count = static_cast<std::size_t>(input.GetNumberOfPoints());
  if (count >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(count) + " points; at most 4294967294 fit a tree in memory" };
  }
  if (count > 0 && input.GetPoints()->GetData()->GetNumberOfComponents() != 3)
  {
    return Error{ ErrorCode::InvalidInput,
      "points have " + std::to_string(input.GetPoints()->GetData()->GetNumberOfComponents()) +
        " coordinates, not 3" };
  }
  std::vector<Vec3> points(count);
  std::atomic<bool> finite{ true };
  execution.parallelFor(count, 1 << 16,
    [&](std::size_t begin, std::size_t end)
    {
      const auto here = std::span(points).subspan(begin, end - begin);
      CopyPoints(*input.GetPoints(), begin, here);
      if (!std::all_of(here.begin(), here.end(), IsFinite))
      {
        finite = false;
      }
    });
  if (!finite && !any)
  {
    const auto bad = std::find_if_not(points.begin(), points.end(), IsFinite);
    return Error{ ErrorCode::InvalidInput,
      "point " + std::to_string(bad - points.begin()) + ": a coordinate is not finite" };
  }
  return points;
}

Status CheckCells(vtkPolyData& input)
{
  const std::array<vtkCellArray*, 4> kinds{ input.GetVerts(), input.GetLines(), input.GetPolys(),
    input.GetStrips() };
  const auto areThere = [&](vtkCellArray* cells)
  {
    if (cells && !CheckOffsets(*cells, 0))
    {
      return false;
    }
    if (!cells || cells->GetNumberOfConnectivityIds() == 0)
    {
      return true;
    }
    double range[2];
    cells->GetConnectivityArray()->GetRange(range, 0);
    return range[0] >= 0 && range[1] < static_cast<double>(input.GetNumberOfPoints());
  };
  if (std::all_of(kinds.begin(), kinds.end(), areThere))
  {
    return {};
  }
  const Result<PolyDataElements> read = ReadElements(input); // the error names the cell
  return read ? Status() : Status(read.GetError());
}

Result<PolyDataElements> ReadElements(vtkPolyData& input)
{
  const vtkIdType points = input.GetNumberOfPoints();
  const vtkIdType lines = input.GetNumberOfVerts();
  const vtkIdType polygons = lines + input.GetNumberOfLines();
  const vtkIdType strips = polygons + input.GetNumberOfPolys();
  PolyDataElements elements;
  KDSTREAM_TRY(ReadCells(input.GetVerts(), 0, points, AddVertices, elements));
  elements.vertices = elements.corners.size();
  KDSTREAM_TRY(ReadCells(input.GetLines(), lines, points, AddSegments, elements));
  elements.segments = elements.corners.size() - elements.vertices;
  const auto triangles = static_cast<std::size_t>(input.GetNumberOfPolys());
  elements.corners.reserve(elements.corners.size() + triangles);
  elements.cells.reserve(elements.cells.size() + triangles);
  KDSTREAM_TRY(
    ReadCells(input.GetPolys(), polygons, points, AddPolygons(input.GetPoints()), elements));
  KDSTREAM_TRY(ReadCells(input.GetStrips(), strips, points, AddStrip, elements));
  if (elements.corners.size() > std::numeric_limits<std::uint32_t>::max())
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(elements.corners.size()) +
        " triangles, lines and vertices; at most 4294967295 are possible" };
  }
  return elements;
}

Result<std::vector<std::int64_t>> ReadLabels(vtkDataArray& array, vtkIdType points)
{
  const std::string name = array.GetName() ? array.GetName() : "";
  if (array.GetNumberOfComponents() != 1 || array.GetNumberOfTuples() != points)
  {
    return Error{ ErrorCode::InvalidInput,
      "the array \"" + name + "\" has " + std::to_string(array.GetNumberOfTuples()) +
        " tuples of " + std::to_string(array.GetNumberOfComponents()) + " components for " +
        std::to_string(points) + " points" };
  }
  std::vector<std::int64_t> labels;
  labels.reserve(static_cast<std::size_t>(points));
  LabelReader reader{ labels };
  if (!vtkArrayDispatch::Dispatch::Execute(&array, reader))
  {
    reader.ReadAny(array);
  }
  if (const auto read = static_cast<vtkIdType>(labels.size()); read < points)
  {
    return Error{ ErrorCode::InvalidInput,
      "the array \"" + name + "\": value " + std::to_string(array.GetComponent(read, 0)) +
        " of point " + std::to_string(read) + " is not a whole number" };
  }
  return labels;
}

Result<Mesh> ReadMesh(vtkPolyData& input, const Execution& execution, bool any)
{
  Result<std::vector<Vec3>> points = ReadPoints(input, execution, any);
  KDSTREAM_TRY(points);
  Result<PolyDataElements> elements = ReadElements(input);
  KDSTREAM_TRY(elements);
  Mesh mesh;
  mesh.points = std::move(*points);
  const std::span<const Triangle> triangles = elements->Triangles();
  mesh.triangles.assign(triangles.begin(), triangles.end());
  mesh.scalarType = input.GetPoints() && input.GetPoints()->GetDataType() == VTK_FLOAT
                      ? ScalarType::Float32
                      : ScalarType::Float64;
  return mesh;
}

}
