// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. the input as one mesh: points, triangles, normals and colours in core's types  2. weld,
// tree, level (core)
// 3. VTK arrays.
#include "vtkKdClusterSimplification.h"

#include "filters/Simplification/SimplifiedLevel.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/core/Weld.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationInformationVectorKey.h>
#include <vtkInformationStringKey.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

vtkStandardNewMacro(vtkKdClusterSimplification);

KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, TargetNumberOfTriangles, vtkIdType, 0, VTK_ID_MAX)
KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, CellVertices, int, 1, 1024)
KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX)

namespace
{

using namespace kdstream;

// Cluster ids travel as an attribute while points are welded, so that only points of one cluster
// are joined. VTK arrays without a name are skipped, so no other attribute is called so.
const char* const clusterIdName = "";

// What levels carry: normals and colours. Other arrays must not keep points apart.
std::vector<Attribute> ReadLevelAttributes(vtkPolyData& input, const PolyDataElements& elements)
{
  std::vector<Attribute> attributes = ReadAttributes(input, elements).attributes;
  const auto isOther = [](const Attribute& attribute)
  {
    const AttributeRole role = RoleOf(attribute);
    return role != AttributeRole::Normals && role != AttributeRole::Colors;
  };
  attributes.erase(std::remove_if(attributes.begin(), attributes.end(), isOther), attributes.end());
  return attributes;
}

Result<Mesh> ReadSimplifiable(vtkPolyData& input, const Execution& execution)
{
  Result<Mesh> mesh = ReadMesh(input, execution);
  if (mesh)
  {
    // Cannot fail: ReadMesh has read them already.
    mesh->attributes = ReadLevelAttributes(input, *ReadElements(input));
  }
  return mesh;
}

// One whole number for each point.
Result<Attribute> ReadClusterIds(vtkDataArray* array, vtkIdType points)
{
  if (!array)
  {
    return Error{ ErrorCode::InvalidArgument, "the input has no such point array of cluster ids" };
  }
  const std::string name = array->GetName() ? array->GetName() : "";
  if (array->GetNumberOfComponents() != 1 || array->GetNumberOfTuples() != points)
  {
    return Error{ ErrorCode::InvalidInput,
      "array \"" + name + "\" has not one cluster id a point" };
  }
  Attribute ids{ { clusterIdName, AttributeType::Int64, AttributeAssociation::Point, 1 }, {} };
  ids.values.resize(static_cast<std::size_t>(points) * sizeof(std::int64_t));
  for (vtkIdType i = 0; i < points; ++i)
  {
    const double value = array->GetComponent(i, 0);
    if (!(std::abs(value) <= 9007199254740992.0) || value != std::floor(value))
    {
      return Error{ ErrorCode::InvalidInput, "array \"" + name + "\": value " +
                                               std::to_string(value) + " of point " +
                                               std::to_string(i) + " is not a whole number" };
    }
    ids.Set(static_cast<std::size_t>(i), 0, value);
  }
  return ids;
}

// The level of the clusters that `ids` tells; welds with them.
Result<ClusterLevel> SimplifyClusters(
  Mesh& mesh, Attribute ids, bool weld, const ClusterOptions& options, const Execution& execution)
{
  mesh.attributes.push_back(std::move(ids));
  if (weld)
  {
    WeldVertices(mesh);
  }
  const Attribute welded = std::move(mesh.attributes.back());
  mesh.attributes.pop_back();
  std::vector<std::int64_t> labels(mesh.points.size());
  std::memcpy(labels.data(), welded.values.data(), welded.values.size());
  return SimplifyByClusters(mesh, ClusteringOfLabels(labels), options, execution);
}

void FillPoints(const ClusterLevel& level, ScalarType type, vtkPolyData& output)
{
  const auto count = static_cast<vtkIdType>(level.positions.size());
  vtkNew<vtkPoints> points;
  points->SetDataType(type == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(count);
  vtkNew<vtkDoubleArray> deviations;
  deviations->SetName("Deviation");
  deviations->SetNumberOfValues(count);
  for (vtkIdType i = 0; i < count; ++i)
  {
    const auto cluster = static_cast<std::size_t>(i);
    points->SetPoint(i, level.positions[cluster].data());
    deviations->SetValue(i, level.deviations[cluster]);
  }
  output.SetPoints(points);
  output.GetPointData()->AddArray(deviations);
}

void FillCells(const ClusterLevel& level, bool cloud, vtkPolyData& output)
{
  vtkNew<vtkCellArray> cells;
  if (cloud)
  {
    const auto count = static_cast<vtkIdType>(level.positions.size());
    cells->AllocateExact(count, count);
    for (vtkIdType i = 0; i < count; ++i)
    {
      cells->InsertNextCell(1, &i);
    }
    output.SetVerts(cells);
    return;
  }
  const auto triangles = static_cast<vtkIdType>(level.triangles.size());
  cells->AllocateExact(triangles, 3 * triangles);
  for (const Triangle& t : level.triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  output.SetPolys(cells);
}

Status FillOutput(const ClusterLevel& level, const Mesh& mesh, vtkPolyData& output)
{
  FillPoints(level, mesh.scalarType, output);
  FillCells(level, mesh.triangles.empty(), output);
  return WriteAttributes(level.attributes, output);
}

// What the filter is asked for.
struct Request
{
  SimplificationOptions options;
  bool weld = true;
  bool byClusters = false;
  vtkDataArray* clusterIds = nullptr; // null where there is no such array
};

Status Simplify(vtkPolyData& input, const Request& request, const Execution& execution,
  vtkPolyData& output, int& finestDepth)
{
  Result<Mesh> mesh = ReadSimplifiable(input, execution);
  KDSTREAM_TRY(mesh);
  if (request.byClusters)
  {
    Result<Attribute> ids = ReadClusterIds(request.clusterIds, input.GetNumberOfPoints());
    KDSTREAM_TRY(ids);
    const Result<ClusterLevel> level =
      SimplifyClusters(*mesh, std::move(*ids), request.weld, request.options.levels, execution);
    return level ? FillOutput(*level, *mesh, output) : level.GetError();
  }
  if (request.weld)
  {
    WeldVertices(*mesh);
  }
  const Result<SimplifiedLevel> level = SimplifyMesh(*mesh, request.options, execution);
  KDSTREAM_TRY(level);
  finestDepth = static_cast<int>(level->finestDepth);
  return FillOutput(level->level, *mesh, output);
}

}

const char* vtkKdClusterSimplification::GetMakerAsString() const
{
  return this->Maker == Collapse ? "Collapse" : "Cluster";
}

const char* vtkKdClusterSimplification::GetRepresentativeAsString() const
{
  return this->Representative == Mean ? "Mean" : "Quadric";
}

int vtkKdClusterSimplification::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

bool vtkKdClusterSimplification::HasClusters()
{
  vtkInformationVector* const arrays =
    this->GetInformation()->Get(vtkAlgorithm::INPUT_ARRAYS_TO_PROCESS());
  if (!arrays)
  {
    return false;
  }
  const char* const name = arrays->GetInformationObject(0)->Get(vtkDataObject::FIELD_NAME());
  return !name || *name != '\0'; // without a name: an attribute, such as the scalars
}

int vtkKdClusterSimplification::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* const output = vtkPolyData::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  this->FinestDepth = -1;
  const Execution execution =
    MakeAlgorithmExecution(*this, { { "tree", 0.05, 0.4 }, { "levels", 0.4, 1.0 } });
  const auto input =
    JoinInput(*this, *vtkDataObject::GetData(inputVector[0]), this->WeldByPlace, execution);
  if (!input)
  {
    this->SetErrorCode(ReportError(*this, input.GetError()));
    return 0;
  }
  if ((*input)->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  Request request;
  KdTreeOptions& tree = request.options.tree;
  tree.verticesPerPartition = static_cast<std::uint32_t>(this->VerticesPerPartition);
  tree.cellVertices = static_cast<std::uint32_t>(this->CellVertices);
  LevelOptions& levels = request.options.levels;
  static_assert(int(LevelMaker::Collapse) == Collapse && int(LevelMaker::Cluster) == Cluster);
  levels.maker = static_cast<LevelMaker>(this->Maker);
  levels.representative = this->Representative == Mean ? kdstream::Representative::Mean
                                                       : kdstream::Representative::Quadric;
  levels.sheets = this->Sheets;
  if (this->Depth >= 0)
  {
    request.options.depth = static_cast<unsigned>(this->Depth);
  }
  request.options.target = static_cast<std::size_t>(this->TargetNumberOfTriangles);
  request.weld = this->Weld;
  request.byClusters = this->HasClusters();
  request.clusterIds = request.byClusters ? this->GetInputArrayToProcess(0, *input) : nullptr;

  const Status status = Simplify(**input, request, execution, *output, this->FinestDepth);
  if (!status)
  {
    output->Initialize();
  }
  this->SetErrorCode(ReportError(*this, status));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

void vtkKdClusterSimplification::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Maker: " << this->GetMakerAsString() << "\n";
  os << indent << "TargetNumberOfTriangles: " << this->TargetNumberOfTriangles << "\n";
  os << indent << "Depth: " << this->Depth << "\n";
  os << indent << "Representative: " << this->GetRepresentativeAsString() << "\n";
  os << indent << "Sheets: " << (this->Sheets ? "on" : "off") << "\n";
  os << indent << "Weld: " << (this->Weld ? "on" : "off") << "\n";
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
  os << indent << "CellVertices: " << this->CellVertices << "\n";
  os << indent << "VerticesPerPartition: " << this->VerticesPerPartition << "\n";
  os << indent << "FinestDepth: " << this->FinestDepth << "\n";
}
