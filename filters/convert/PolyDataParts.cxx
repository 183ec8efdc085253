// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/PolyDataParts.h"

#include "filters/adapter/JoinPolyData.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/meshio/DroppedPoints.h"

namespace kdstream
{
namespace
{

// "1 line cell", "2 line cells".
std::string CellsText(vtkIdType count, const std::string& kind)
{
  return std::to_string(count) + " " + kind + (count == 1 ? " cell" : " cells");
}

// Warns of cells that a mesh does not have: all except triangles. A cloud needs no cells, so
// missing vertex cells are no loss.
void WarnOfCells(const PolyDataElements& elements, bool triangles, vtkPolyData& input,
  std::vector<std::string>& warnings)
{
  std::string cells;
  if (elements.segments > 0)
  {
    cells = CellsText(input.GetNumberOfLines(), "line");
  }
  if (elements.vertices > 0 && triangles)
  {
    cells += (cells.empty() ? "" : " and ") + CellsText(input.GetNumberOfVerts(), "vertex");
  }
  if (!cells.empty())
  {
    warnings.push_back("left out: " + cells + "; their points stay");
  }
}

}

Result<ForeignMesh> ReadPolyData(vtkPolyData& data, const Execution& execution)
{
  const Result<JoinedPolyData> own = JoinPolyData(data, false, execution); // without ghosts
  KDSTREAM_TRY(own);
  vtkPolyData& input = *own->mesh;
  ForeignMesh result;
  if (const vtkIdType ghosts = data.GetNumberOfCells() - input.GetNumberOfCells(); ghosts > 0)
  {
    result.warnings.push_back("left out: " + CellsText(ghosts, "ghost") +
                              " (marked as duplicate or hidden by vtkGhostType)");
  }
  const Result<PolyDataElements> elements = ReadElements(input);
  Result<Mesh> mesh = ReadMesh(input, execution, true);
  if (!elements || !mesh)
  {
    return !elements ? elements.GetError() : mesh.GetError();
  }
  result.mesh = std::move(*mesh);
  PolyDataAttributes read = ReadAttributes(input, *elements);
  result.mesh.attributes = std::move(read.attributes);
  for (const auto& skipped : { own->leftOut, read.skipped })
  {
    for (const std::string& array : skipped)
    {
      result.warnings.push_back("dropped: " + array);
    }
  }
  WarnOfCells(*elements, !result.mesh.triangles.empty(), input, result.warnings);
  const std::size_t first = elements->vertices + elements->segments;
  std::vector<bool> begins; // for each triangle: whether it is the first of its cell
  for (std::size_t i = first; i < elements->corners.size(); ++i)
  {
    begins.push_back(i == first || elements->cells[i] != elements->cells[i - 1]);
  }
  const Result<std::vector<bool>> finite = DropNotFinite(result.mesh, begins, result.tolerance);
  KDSTREAM_TRY(finite);
  return result;
}

}
