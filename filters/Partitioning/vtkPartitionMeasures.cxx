// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. Join the input into one mesh; read labels.  2. Compute the measures (core).  3. Fill
// the tables.
#include "vtkPartitionMeasures.h"

#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/core/tree/PartitionMeasures.h"

#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkTable.h>

#include <string>
#include <vector>

vtkStandardNewMacro(vtkPartitionMeasures);

namespace
{

using namespace kdstream;

void AddIds(vtkTable& table, const char* name, const std::vector<std::int64_t>& values)
{
  vtkNew<vtkIdTypeArray> column;
  column->SetName(name);
  for (const std::int64_t value : values)
  {
    column->InsertNextValue(static_cast<vtkIdType>(value));
  }
  table.AddColumn(column);
}

void AddNumbers(vtkTable& table, const std::string& name, const std::vector<double>& values)
{
  vtkNew<vtkDoubleArray> column;
  column->SetName(name.c_str());
  for (const double value : values)
  {
    column->InsertNextValue(value);
  }
  table.AddColumn(column);
}

template <class Value>
std::vector<Value> Values(const PartitionMeasures& measures, const auto PartitionMeasure::*member)
{
  std::vector<Value> values;
  values.reserve(measures.partitions.size());
  for (const PartitionMeasure& partition : measures.partitions)
  {
    values.push_back(static_cast<Value>(partition.*member));
  }
  return values;
}

void FillPartitions(
  vtkTable& table, const PartitionMeasures& measures, const std::vector<std::int64_t>& ids)
{
  AddIds(table, "PartitionId", ids);
  AddIds(table, "Vertices", Values<std::int64_t>(measures, &PartitionMeasure::vertices));
  AddIds(table, "Triangles", Values<std::int64_t>(measures, &PartitionMeasure::triangles));
  AddIds(table, "OwnTriangles", Values<std::int64_t>(measures, &PartitionMeasure::ownTriangles));
  AddNumbers(table, "BoundaryLength", Values<double>(measures, &PartitionMeasure::boundaryLength));
  AddNumbers(table, "Area", Values<double>(measures, &PartitionMeasure::area));
  AddNumbers(table, "Compactness", Values<double>(measures, &PartitionMeasure::compactness));
}

void FillSpread(vtkTable& table, const PartitionMeasures& measures)
{
  AddIds(table, "Partitions", { static_cast<std::int64_t>(measures.partitions.size()) });
  AddIds(table, "Measured", { static_cast<std::int64_t>(measures.measured) });
  const struct
  {
    std::string name;
    const Spread& spread;
  } rows[] = { { "Vertices", measures.vertices }, { "Triangles", measures.triangles },
    { "Compactness", measures.compactness } };
  for (const auto& [name, spread] : rows)
  {
    AddNumbers(table, name + "Minimum", { spread.minimum });
    AddNumbers(table, name + "Maximum", { spread.maximum });
    AddNumbers(table, name + "Mean", { spread.mean });
    AddNumbers(table, name + "StandardDeviation", { spread.standardDeviation });
    AddNumbers(table, name + "Ratio", { spread.ratio });
  }
}

}

vtkPartitionMeasures::vtkPartitionMeasures()
{
  this->SetNumberOfOutputPorts(2);
  this->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "PartitionId");
}

int vtkPartitionMeasures::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

int vtkPartitionMeasures::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->SetErrorCode(vtkErrorCode::NoError);
  const auto fail = [this](const Error& error)
  {
    this->SetErrorCode(ReportError(*this, error));
    return error.code == ErrorCode::Cancelled ? 1 : 0;
  };
  const Execution execution = MakeAlgorithmExecution(*this, { { "measures", 0.2, 1 } });
  const auto input =
    JoinInput(*this, *vtkDataObject::GetData(inputVector[0]), this->WeldByPlace, execution);
  if (!input)
  {
    return fail(input.GetError());
  }
  vtkPolyData& whole = **input;
  std::vector<std::int64_t> labels;
  if (whole.GetNumberOfPoints() > 0)
  {
    vtkDataArray* const array = this->GetInputArrayToProcess(0, &whole);
    Result<std::vector<std::int64_t>> read = Error{ ErrorCode::InvalidInput,
      "there is no point array of partition ids (set it with SetInputArrayToProcess; default "
      "\"PartitionId\")" };
    if (array)
    {
      read = ReadLabels(*array, whole.GetNumberOfPoints());
    }
    if (!read)
    {
      return fail(read.GetError());
    }
    labels = std::move(*read);
  }
  const Result<Mesh> mesh = ReadMesh(whole, execution);
  if (!mesh)
  {
    return fail(mesh.GetError());
  }
  const Clustering clustering = ClusteringOfLabels(labels);
  const Result<PartitionMeasures> measures =
    MeasurePartitions(mesh->points, mesh->triangles, clustering, execution);
  if (!measures)
  {
    return fail(measures.GetError());
  }
  std::vector<std::int64_t> ids(clustering.clusters);
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    ids[clustering.clusterOf[i]] = labels[i];
  }
  FillPartitions(*vtkTable::GetData(outputVector, 0), *measures, ids);
  FillSpread(*vtkTable::GetData(outputVector, 1), *measures);
  return 1;
}

void vtkPartitionMeasures::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
}
