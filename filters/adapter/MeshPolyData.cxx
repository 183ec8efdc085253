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

// Cells of `size` corners each.
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
  const std::function<bool(const AttributeInfo&)>& isWanted, vtkPolyData& output)
{
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.scalarType == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    points->SetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  }
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
    for (const Triangle& t : mesh.triangles)
    {
      out = std::copy(t.begin(), t.end(), out);
    }
    SetCells(mesh.triangles.size(), 3, corners, *cells);
    output.SetPolys(cells);
  }

  std::vector<Attribute> wanted;
  std::copy_if(
    mesh.attributes.begin(), mesh.attributes.end(), std::back_inserter(wanted), isWanted);
  return WriteAttributes(wanted, output);
}

}
