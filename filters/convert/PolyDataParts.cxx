// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/PolyDataParts.h"

#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/convert/PointAttributes.h"
#include "filters/meshio/DroppedPoints.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

bool IsColor(const Attribute& attribute)
{
  return RoleOf(attribute) == AttributeRole::Colors;
}

// Colours of three components become ones of four, if they are to have `alpha`; none become white.
void GiveColors(Mesh& mesh, bool alpha)
{
  auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(), IsColor);
  Attribute colors = MakeColors(mesh.points.size(), alpha);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    for (std::size_t k = 0; k < colors.components; ++k)
    {
      const bool known = found != mesh.attributes.end() && k < found->components;
      colors.values[i * colors.components + k] =
        known ? found->values[i * found->components + k] : 255;
    }
  }
  if (found != mesh.attributes.end())
  {
    mesh.attributes.erase(found);
  }
  mesh.attributes.push_back(std::move(colors));
}

// "1 line cell", "2 line cells".
std::string CellsText(vtkIdType count, const std::string& kind)
{
  return std::to_string(count) + " " + kind + (count == 1 ? " cell" : " cells");
}

void AddWarning(std::vector<std::string>& warnings, const std::string& warning)
{
  if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end())
  {
    warnings.push_back(warning);
  }
}

// Of the cells that a mesh has not: all but triangles. A cloud needs none, so its vertices are no
// loss.
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

// Whether all parts with points have it.
bool InAll(const AttributeInfo& info, std::span<const ForeignMesh> parts)
{
  return std::all_of(parts.begin(), parts.end(),
    [&](const ForeignMesh& part)
    { return part.mesh.points.empty() || FindAttribute(part.mesh.attributes, info) != nullptr; });
}

void UnifyColors(std::span<ForeignMesh> parts)
{
  std::size_t with = 0, withAlpha = 0;
  for (const ForeignMesh& part : parts)
  {
    const auto& attributes = part.mesh.attributes;
    const auto found = std::find_if(attributes.begin(), attributes.end(), IsColor);
    with += found != attributes.end();
    withAlpha += found != attributes.end() && found->components == 4;
  }
  if (with > 0 && (with < parts.size() || (withAlpha > 0 && withAlpha < with)))
  {
    for (ForeignMesh& part : parts)
    {
      GiveColors(part.mesh, withAlpha > 0);
    }
  }
}

}

Result<ForeignMesh> ReadPolyData(vtkPolyData& input, const Execution& execution)
{
  ForeignMesh result;
  const Result<PolyDataElements> elements = ReadElements(input);
  Result<Mesh> mesh = ReadMesh(input, execution, true);
  if (!elements || !mesh)
  {
    return !elements ? elements.GetError() : mesh.GetError();
  }
  result.mesh = std::move(*mesh);
  PolyDataAttributes read = ReadAttributes(input, *elements);
  result.mesh.attributes = std::move(read.attributes);
  for (const std::string& skipped : read.skipped)
  {
    result.warnings.push_back("dropped: " + skipped);
  }
  WarnOfCells(*elements, !result.mesh.triangles.empty(), input, result.warnings);
  const std::size_t first = elements->vertices + elements->segments;
  std::vector<bool> begins; // of each triangle: whether it is the first of its cell
  for (std::size_t i = first; i < elements->corners.size(); ++i)
  {
    begins.push_back(i == first || elements->cells[i] != elements->cells[i - 1]);
  }
  const Result<std::vector<bool>> finite = DropNotFinite(result.mesh, begins, result.tolerance);
  KDSTREAM_TRY(finite);
  return result;
}

ForeignMesh JoinParts(std::span<ForeignMesh> parts)
{
  ForeignMesh joined;
  UnifyColors(parts);
  Mesh& mesh = joined.mesh;
  mesh.scalarType = ScalarType::Float32;
  std::vector<AttributeInfo> kept;
  for (const ForeignMesh& part : parts)
  {
    for (const Attribute& attribute : part.mesh.attributes)
    {
      if (!InAll(attribute, parts))
      {
        AddWarning(
          joined.warnings, "array \"" + attribute.name + "\" is dropped: not all parts have it");
      }
      else if (!FindAttribute(mesh.attributes, attribute))
      {
        Attribute empty;
        static_cast<AttributeInfo&>(empty) = attribute;
        mesh.attributes.push_back(std::move(empty));
      }
    }
    for (const std::string& warning : part.warnings)
    {
      AddWarning(joined.warnings, warning);
    }
  }
  for (const ForeignMesh& part : parts)
  {
    if (part.mesh.points.empty())
    {
      continue;
    }
    const auto offset = static_cast<VertexId>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), part.mesh.points.begin(), part.mesh.points.end());
    for (const Triangle& t : part.mesh.triangles)
    {
      mesh.triangles.push_back({ t[0] + offset, t[1] + offset, t[2] + offset });
    }
    if (part.mesh.scalarType == ScalarType::Float64)
    {
      mesh.scalarType = ScalarType::Float64;
    }
    for (Attribute& attribute : mesh.attributes)
    {
      const Attribute* const from = FindAttribute(part.mesh.attributes, attribute);
      attribute.values.insert(attribute.values.end(), from->values.begin(), from->values.end());
    }
  }
  return joined;
}

}
