// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Join the input into one mesh, with points and cells in core's types.
// 2. The subclass assigns each point to a partition.
// 3. Determine which elements go to which partition (PartitionLayout).
// 4. Make each partition with its arrays.
#include "vtkMeshPartition.h"

#include "filters/Partitioning/CutPartitions.h"
#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/JoinPolyData.h"
#include "filters/adapter/PartitionLayout.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/core/TakeResult.h"

#include <vtkDemandDrivenPipeline.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationRequestKey.h>
#include <vtkInformationVector.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <utility>
#include <vector>

KDSTREAM_SET_IN_RANGE(vtkMeshPartition, VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX)
KDSTREAM_SET_IN_RANGE(vtkMeshPartition, NumberOfPartitions, vtkIdType, 0, 1 << 30)

using namespace kdstream;

// One execution.
struct vtkMeshPartition::Run
{
  vtkMeshPartition& Self;
  vtkPolyData& Input;
  vtkMTimeType InputTime; // when the inputs of the joined mesh were last changed
  const Execution& Runs;

  Status Make(bool isCut, vtkInformationVector& outputVector) const
  {
    PolyDataElements elements;
    KDSTREAM_TRY(isCut || this->Self.UsesCells() ? Take(ReadElements(this->Input), elements)
                                                 : CheckCells(this->Input));
    KDSTREAM_TRY(this->Assign(elements));
    std::vector<vtkSmartPointer<vtkPolyData>> made;
    const auto labels =
      this->Self.GeneratePartitionIds ? NewPartitionIds(this->Self.Assigned->partitionOf) : nullptr;
    if (isCut)
    {
      KDSTREAM_TRY(Take(this->Cut(elements), made));
      vtkPartitionedDataSet* const partitions = vtkPartitionedDataSet::GetData(&outputVector, 0);
      partitions->SetNumberOfPartitions(static_cast<unsigned int>(made.size()));
      for (std::size_t i = 0; i < made.size(); ++i)
      {
        partitions->SetPartition(static_cast<unsigned int>(i), made[i]);
      }
    }
    vtkPolyData* const labelled = vtkPolyData::GetData(&outputVector, 1);
    labelled->ShallowCopy(&this->Input);
    if (labels)
    {
      labelled->GetPointData()->AddArray(labels);
    }
    return {};
  }

private:
  // Assigns each point to a partition; does nothing if this was done when port 1 was requested
  // before port 0.
  Status Assign(const PolyDataElements& elements) const
  {
    std::unique_ptr<PartitionAssignment>& assigned = this->Self.Assigned;
    const vtkMTimeType filterTime = this->Self.GetMTime();
    const auto points = static_cast<std::size_t>(this->Input.GetNumberOfPoints());
    if (assigned && assigned->inputTime == this->InputTime && assigned->filterTime == filterTime &&
        assigned->partitionOf.size() == points)
    {
      return {};
    }
    assigned.reset();
    const Result<std::vector<Vec3>> places = ReadPoints(this->Input, this->Runs);
    KDSTREAM_TRY(places);
    MeshPartitionWork work{ *places, elements.Triangles(),
      static_cast<std::uint32_t>(this->Self.VerticesPerPartition), {}, this->Runs };
    if (this->Self.NumberOfPartitions > 0)
    {
      work.wantedPartitions = static_cast<std::uint32_t>(this->Self.NumberOfPartitions);
    }
    this->Self.AssignPoints(work);
    KDSTREAM_TRY(work.status);
    assigned = std::make_unique<PartitionAssignment>(PartitionAssignment{
      std::move(work.partitionOf), work.partitions, this->InputTime, filterTime });
    return {};
  }

  Result<std::vector<vtkSmartPointer<vtkPolyData>>> Cut(const PolyDataElements& elements) const
  {
    const std::unique_ptr<PartitionAssignment> assigned = std::move(this->Self.Assigned);
    const PartitionLayout layout(
      std::move(assigned->partitionOf), assigned->partitions, elements.corners);
    return CutPartitions(this->Input, elements, layout, this->Self.GeneratePartitionIds, 0,
      assigned->partitions, this->Runs);
  }
};

vtkMeshPartition::vtkMeshPartition()
{
  this->SetNumberOfOutputPorts(2);
}

vtkMeshPartition::~vtkMeshPartition() = default;

int vtkMeshPartition::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

int vtkMeshPartition::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPartitionedDataSet" : "vtkPolyData");
  return 1;
}

bool vtkMeshPartition::AsksForPartitions(vtkInformation* request)
{
  return request->Get(vtkExecutive::FROM_OUTPUT_PORT()) != 1;
}

vtkTypeBool vtkMeshPartition::ProcessRequest(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA_NOT_GENERATED()))
  {
    if (!AsksForPartitions(request))
    {
      outputVector->GetInformationObject(0)->Set(vtkDemandDrivenPipeline::DATA_NOT_GENERATED(), 1);
    }
    return 1;
  }
  return this->Superclass::ProcessRequest(request, inputVector, outputVector);
}

int vtkMeshPartition::RequestData(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  const bool isCut = AsksForPartitions(request);
  const double cutAt = isCut ? 0.5 : 1.0;
  const Execution execution = MakeAlgorithmExecution(
    *this, { { "tree", 0.05, cutAt }, { "octree", 0.05, cutAt }, { "faces", 0.05, 0.4 * cutAt },
             { "seeds", 0.4 * cutAt, 0.4 * cutAt }, { "k-means", 0.4 * cutAt, cutAt },
             { "partitions", 0.5, 1.0 } });
  vtkDataObject& input = *vtkDataObject::GetData(inputVector[0]);
  const auto joined = JoinInput(*this, input, this->WeldByPlace, execution);
  Status status = joined ? Status() : Status(joined.GetError());
  if (joined && (*joined)->GetNumberOfPoints() > 0)
  {
    status = Run{ *this, **joined, TimeOf(input), execution }.Make(isCut, *outputVector);
  }
  this->SetErrorCode(ReportError(*this, status));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

void vtkMeshPartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VerticesPerPartition: " << this->VerticesPerPartition << "\n";
  os << indent << "NumberOfPartitions: " << this->NumberOfPartitions << "\n";
  os << indent << "GeneratePartitionIds: " << (this->GeneratePartitionIds ? "on" : "off") << "\n";
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
}
