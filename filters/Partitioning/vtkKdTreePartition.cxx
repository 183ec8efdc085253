// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdTreePartition.h"

#include "filters/Partitioning/CutPartitions.h"
#include "filters/Partitioning/DistributedPartition.h"
#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/RankPipeline.h"
#include "filters/core/TakeResult.h"
#include "filters/core/tree/Clustering.h"
#include "filters/core/tree/KdTree.h"

#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiProcessController.h>
#include <vtkObjectFactory.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <string>
#include <utility>

using namespace kdstream;

namespace
{

// All ranks must have the same options.
Status AgreeOnOptions(RankGroup& ranks, vtkKdTreePartition& filter, bool isCut)
{
  const std::pair<const char*, vtkIdType> options[] = { { "VerticesPerPartition",
                                                          filter.GetVerticesPerPartition() },
    { "NumberOfPartitions", filter.GetNumberOfPartitions() },
    { "GeneratePartitionIds", filter.GetGeneratePartitionIds() },
    { "WeldByPlace", filter.GetWeldByPlace() }, { "the output port", isCut ? 0 : 1 } };
  for (const auto& [name, value] : options)
  {
    const auto all = ranks.Gather(static_cast<std::uint64_t>(value));
    KDSTREAM_TRY(all);
    for (std::size_t rank = 1; rank < all->size(); ++rank)
    {
      if ((*all)[rank] != all->front())
      {
        return ranks.FailCollectively({ ErrorCode::InvalidArgument,
          std::string("all ranks need the same options: ") + name + " is " +
            std::to_string(all->front()) + " on rank 0, and " + std::to_string((*all)[rank]) +
            " on rank " + std::to_string(rank) });
      }
    }
  }
  return {};
}

}

vtkStandardNewMacro(vtkKdTreePartition);

vtkCxxSetObjectMacro(vtkKdTreePartition, Controller, vtkMultiProcessController);

vtkKdTreePartition::vtkKdTreePartition()
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkKdTreePartition::~vtkKdTreePartition()
{
  this->SetController(nullptr);
}

vtkExecutive* vtkKdTreePartition::CreateDefaultExecutive()
{
  return RankPipeline::Make(
    this->Controller, [this](unsigned long code) { this->SetErrorCode(code); });
}

int vtkKdTreePartition::RequestData(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (!AreSeveral(this->Controller))
  {
    return this->Superclass::RequestData(request, inputVector, outputVector);
  }
  const Execution execution =
    MakeAlgorithmExecution(*this, { { "tree", 0.05, 0.7 }, { "partitions", 0.7, 1.0 } });
  DistributedOptions options;
  options.tree.verticesPerPartition = static_cast<std::uint32_t>(this->GetVerticesPerPartition());
  if (this->GetNumberOfPartitions() > 0)
  {
    options.tree.partitions = static_cast<std::uint32_t>(this->GetNumberOfPartitions());
  }
  options.isCut = AsksForPartitions(request);
  options.generateIds = this->GetGeneratePartitionIds();
  vtkDataObject& data = *vtkDataObject::GetData(inputVector[0]);
  vtkSmartPointer<vtkPolyData> input;
  RankGroup ranks(*this->Controller);
  const auto made = RunCollectively(ranks,
    [&]() -> Result<DistributedPartitions>
    {
      KDSTREAM_TRY(AgreeOnOptions(ranks, *this, options.isCut));
      KDSTREAM_TRY(
        ranks.Agree(Take(JoinInput(*this, data, this->GetWeldByPlace(), execution), input)));
      return PartitionCollectively(ranks, *input, options, execution);
    });
  this->SetErrorCode(ReportError(*this, made ? Status() : Status(made.GetError())));
  if (!made)
  {
    return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
  }
  WarnOfArrays(*this, made->skipped);
  if (made->areSame)
  {
    WarnOfSameMesh(*this);
  }
  if (options.isCut)
  {
    vtkPartitionedDataSet* const partitions = vtkPartitionedDataSet::GetData(outputVector, 0);
    partitions->SetNumberOfPartitions(static_cast<unsigned int>(made->partitions));
    for (std::size_t i = 0; i < made->made.size(); ++i)
    {
      partitions->SetPartition(static_cast<unsigned int>(made->first + i), made->made[i]);
    }
  }
  vtkPolyData* const labelled = vtkPolyData::GetData(outputVector, 1);
  labelled->ShallowCopy(input);
  if (options.generateIds)
  {
    labelled->GetPointData()->AddArray(NewPartitionIds(made->partitionOf));
  }
  return 1;
}

void vtkKdTreePartition::AssignPoints(MeshPartitionWork& work)
{
  work.Take(ClusterByKdTree(
    work.points, { work.verticesPerPartition, work.wantedPartitions }, work.execution));
}

void vtkKdTreePartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Controller: " << static_cast<void*>(this->Controller) << "\n";
}
