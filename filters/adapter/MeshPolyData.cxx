// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/MeshPolyData.h"

#include "filters/adapter/PolyDataAttributes.h"

#include <vtkCellArray.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <vector>

namespace kdstream
{
namespace
{

// Calls visit(i) for 0, 1, … count - 1. Reports now and then, and stops if it is told to.
template <class Visit>
Status ForEach(std::size_t count, const Execution& execution, const Visit& visit)
{
  constexpr std::size_t atOnce = std::size_t{ 1 } << 18; // a few milliseconds
  for (std::size_t begin = 0; begin < count; begin += atOnce)
  {
    if (begin > 0)
    {
      KDSTREAM_TRY(execution.Report("fill", double(begin) / double(count)));
    }
    for (std::size_t i = begin; i < std::min(count, begin + atOnce); ++i)
    {
      visit(i);
    }
  }
  return {};
}

// Fills in cells with `size` corners each.
void SetCells(std::size_t count, vtkIdType size, vtkIdTypeArray* corners, vtkCellArray& cells)
{
  vtkNew<vtkIdTypeArray> offsets;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count) + 1);
  for (vtkIdType i = 0; i <= static_cast<vtkIdType>(count); ++i)
  {
    offsets->SetValue(i, i * size);
  }
  cells.SetData(offsets, corners);
}

}

Status FillPolyData(const Mesh& mesh, std::size_t cloudCells,
  const std::function<bool(const AttributeInfo&)>& isWanted, vtkPolyData& output,
  const Execution& execution)
{
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.scalarType == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  KDSTREAM_TRY(ForEach(mesh.points.size(), execution,
    [&](std::size_t i) { points->SetPoint(static_cast<vtkIdType>(i), mesh.points[i].data()); }));
  output.SetPoints(points);

  vtkNew<vtkIdTypeArray> corners;
  vtkNew<vtkCellArray> cells;
  if (mesh.triangles.empty())
  {
    corners->SetNumberOfValues(static_cast<vtkIdType>(cloudCells));
    std::iota(corners->GetPointer(0), corners->GetPointer(0) + cloudCells, vtkIdType{ 0 });
    SetCells(cloudCells, 1, corners, *cells);
    output.SetVerts(cells);
  }
  else
  {
    corners->SetNumberOfValues(3 * static_cast<vtkIdType>(mesh.triangles.size()));
    vtkIdType* out = corners->GetPointer(0);
    KDSTREAM_TRY(ForEach(mesh.triangles.size(), execution,
      [&](std::size_t i)
      { out = std::copy(mesh.triangles[i].begin(), mesh.triangles[i].end(), out); }));
    SetCells(mesh.triangles.size(), 3, corners, *cells);
    output.SetPolys(cells);
  }

  std::vector<Attribute> wanted;
  std::copy_if(
    mesh.attributes.begin(), mesh.attributes.end(), std::back_inserter(wanted), isWanted);
  return WriteAttributes(wanted, output);
}

}
