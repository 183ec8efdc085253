// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Read the input as one mesh: points, triangles and arrays in core's types.
// 2. Weld, build the tree, make the level (core).
// 3. Compute the other arrays for the level (CarriedArrays.h).
// 4. Fill the VTK arrays.
#include "vtkKdClusterSimplification.h"

#include "filters/Simplification/SimplifiedLevel.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/core/Attribute.h"
#include "filters/core/CarriedArrays.h"
#include "filters/core/TakeResult.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/Weld.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
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
#include <cstring>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkKdClusterSimplification);

KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, TargetNumberOfTriangles, vtkIdType, 0, VTK_ID_MAX)
KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, Depth, int, -1, 30)
KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, CellVertices, int, 1, 1024)
KDSTREAM_SET_IN_RANGE(vtkKdClusterSimplification, VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX)

namespace
{

using namespace kdstream;

// While points are welded, cluster ids are an attribute, so that only points of the same cluster
// are joined. VTK arrays without a name are skipped, so no other attribute has this name.
const char* const clusterIdName = "";

const char* const geometricErrorName = "Deviation";

struct Simplifiable
{
  Mesh mesh;                            // with the arrays that levels carry: normals and colours
  std::vector<Attribute> points, cells; // other arrays; points are welded even if these differ
  // The point that each point was welded to; noVertex: none.
  std::vector<VertexId> newIds;
};

// Whether an array is active as global or pedigree ids, whatever its type. The mean of ids has no
// meaning.
bool IsActiveIds(vtkDataSetAttributes& data, const std::string& name)
{
  const auto is = [&](int type)
  {
    vtkAbstractArray* const ids = data.GetAbstractAttribute(type);
    return ids && ids->GetName() && name == ids->GetName();
  };
  return is(vtkDataSetAttributes::GLOBALIDS) || is(vtkDataSetAttributes::PEDIGREEIDS);
}

void ReadArrays(vtkPolyData& input, const PolyDataElements& elements, Simplifiable& read)
{
  for (Attribute& array : ReadAttributes(input, elements).attributes)
  {
    const AttributeRole role = RoleOf(array);
    const bool isPoint = array.association == AttributeAssociation::Point;
    if (role == AttributeRole::Normals || role == AttributeRole::Colors)
    {
      read.mesh.attributes.push_back(std::move(array));
    }
    else if (!HoldsIds(array) && !(isPoint && array.name == geometricErrorName) &&
             !(isPoint ? IsActiveIds(*input.GetPointData(), array.name)
                       : IsActiveIds(*input.GetCellData(), array.name)))
    {
      (isPoint ? read.points : read.cells).push_back(std::move(array));
    }
  }
}

Result<Simplifiable> ReadSimplifiable(vtkPolyData& input, const Execution& execution)
{
  Simplifiable read;
  KDSTREAM_TRY(Take(ReadMesh(input, execution), read.mesh));
  ReadArrays(input, *ReadElements(input), read); // cannot fail: ReadMesh has read them already
  return read;
}

void Weld(Simplifiable& input, bool weld, const Execution& execution)
{
  if (weld)
  {
    WeldVertices(input.mesh, execution, &input.newIds);
    return;
  }
  input.newIds.resize(input.mesh.points.size());
  std::iota(input.newIds.begin(), input.newIds.end(), VertexId{ 0 });
}

// As in a store, points that no triangle uses have no influence (doc/design.md#unused-vertices).
void DropUnused(Simplifiable& input)
{
  const std::vector<bool> isUsed = FindUsedVertices(input.mesh);
  TakeUnusedVertices(input.mesh, isUsed);
  std::vector<VertexId> numbers(isUsed.size(), noVertex);
  VertexId next = 0;
  for (std::size_t v = 0; v < isUsed.size(); ++v)
  {
    numbers[v] = isUsed[v] ? next++ : noVertex;
  }
  for (VertexId& id : input.newIds)
  {
    id = numbers[id];
  }
}

// The ids as an attribute. array: null if the input does not have it.
Result<Attribute> ReadClusterIds(vtkDataArray* array, vtkIdType points)
{
  if (!array)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the input does not have this point array of cluster ids" };
  }
  const Result<std::vector<std::int64_t>> labels = ReadLabels(*array, points);
  KDSTREAM_TRY(labels);
  Attribute ids{ { clusterIdName, AttributeType::Int64, AttributeAssociation::Point, 1 }, {} };
  ids.values.resize(labels->size() * sizeof(std::int64_t));
  std::memcpy(ids.values.data(), labels->data(), ids.values.size());
  return ids;
}

// Makes the level of the clusters given by `ids`; welds only within clusters.
Result<SimplifiedLevel> SimplifyClusters(Simplifiable& input, Attribute ids, bool weld,
  const ClusterOptions& options, const Execution& execution)
{
  Mesh& mesh = input.mesh;
  mesh.attributes.push_back(std::move(ids));
  Weld(input, weld, execution);
  const Attribute welded = std::move(mesh.attributes.back());
  mesh.attributes.pop_back();
  std::vector<std::int64_t> labels(mesh.points.size());
  std::memcpy(labels.data(), welded.values.data(), welded.values.size());
  SimplifiedLevel level;
  KDSTREAM_TRY(
    Take(SimplifyByClusters(mesh, ClusteringOfLabels(labels), options, execution, &level.clusterOf),
      level.level));
  return level;
}

void FillPoints(const ClusterLevel& level, ScalarType type, vtkPolyData& output)
{
  const auto count = static_cast<vtkIdType>(level.positions.size());
  vtkNew<vtkPoints> points;
  points->SetDataType(type == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(count);
  vtkNew<vtkDoubleArray> geometricErrors;
  geometricErrors->SetName(geometricErrorName);
  geometricErrors->SetNumberOfValues(count);
  for (vtkIdType i = 0; i < count; ++i)
  {
    const auto cluster = static_cast<std::size_t>(i);
    points->SetPoint(i, level.positions[cluster].data());
    geometricErrors->SetValue(i, level.geometricErrors[cluster]);
  }
  output.SetPoints(points);
  output.GetPointData()->AddArray(geometricErrors);
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

// The level's arrays, except normals and colours.
std::vector<Attribute> CarryArrays(
  const Simplifiable& input, const SimplifiedLevel& simplified, const Execution& execution)
{
  const ClusterLevel& level = simplified.level;
  std::vector<VertexId> clusterOf(input.newIds.size());
  std::transform(input.newIds.begin(), input.newIds.end(), clusterOf.begin(),
    [&](VertexId v) { return v == noVertex ? noVertex : simplified.clusterOf[v]; });
  std::vector<Attribute> arrays = MeansOfGroups(input.points, clusterOf, level.positions.size());
  for (Attribute& array : CarryCells(input.cells, input.mesh, simplified.clusterOf,
         { level.positions, level.triangles }, execution))
  {
    arrays.push_back(std::move(array));
  }
  return arrays;
}

// Makes arrays active that are active in the input, by name.
void KeepActive(vtkDataSetAttributes& input, vtkDataSetAttributes& output)
{
  for (int type = 0; type < vtkDataSetAttributes::NUM_ATTRIBUTES; ++type)
  {
    vtkAbstractArray* const active = input.GetAbstractAttribute(type);
    if (active && active->GetName() && output.HasArray(active->GetName()) &&
        !output.GetAbstractAttribute(type))
    {
      output.SetActiveAttribute(active->GetName(), type);
    }
  }
}

Status FillOutput(const Simplifiable& input, const SimplifiedLevel& simplified, vtkPolyData& arrays,
  const Execution& execution, vtkPolyData& output)
{
  FillPoints(simplified.level, input.mesh.scalarType, output);
  FillCells(simplified.level, input.mesh.triangles.empty(), output);
  KDSTREAM_TRY(WriteAttributes(simplified.level.attributes, output));
  KDSTREAM_TRY(WriteAttributes(CarryArrays(input, simplified, execution), output));
  KeepActive(*arrays.GetPointData(), *output.GetPointData());
  KeepActive(*arrays.GetCellData(), *output.GetCellData());
  return {};
}

// The request to the filter.
struct Request
{
  SimplificationOptions options;
  bool weld = true;
  bool byClusters = false;
  vtkDataArray* clusterIds = nullptr; // null if there is no such array
};

Status Simplify(vtkPolyData& input, const Request& request, const Execution& execution,
  vtkPolyData& output, int& finestDepth)
{
  Result<Simplifiable> read = ReadSimplifiable(input, execution);
  KDSTREAM_TRY(read);
  SimplifiedLevel level;
  if (request.byClusters)
  {
    Result<Attribute> ids = ReadClusterIds(request.clusterIds, input.GetNumberOfPoints());
    KDSTREAM_TRY(ids);
    KDSTREAM_TRY(Take(
      SimplifyClusters(*read, std::move(*ids), request.weld, request.options.levels, execution),
      level));
  }
  else
  {
    Weld(*read, request.weld, execution);
    DropUnused(*read);
    KDSTREAM_TRY(Take(SimplifyMesh(read->mesh, request.options, execution), level));
    finestDepth = static_cast<int>(level.finestDepth);
  }
  return FillOutput(*read, level, input, execution, output);
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
  return !name || *name != '\0'; // no name means an attribute, such as the scalars
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
  levels.byComponents = this->Sheets;
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
