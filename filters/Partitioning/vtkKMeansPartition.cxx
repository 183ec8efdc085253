// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKMeansPartition.h"

#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/baselines/KMeansClustering.h"

#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkKMeansPartition);

KDSTREAM_SET_IN_RANGE(vtkKMeansPartition, NumberOfIterations, int, 1, 1000)
KDSTREAM_SET_IN_RANGE(vtkKMeansPartition, DistanceWeight, double, 1e-6, 1e6)
KDSTREAM_SET_IN_RANGE(vtkKMeansPartition, CompactnessWeight, double, 0, 1e6)
KDSTREAM_SET_IN_RANGE(vtkKMeansPartition, CountWeight, double, 0, 1e6)

void vtkKMeansPartition::AssignPoints(kdstream::MeshPartitionWork& work)
{
  kdstream::KMeansOptions options;
  options.verticesPerPartition = work.verticesPerPartition;
  options.partitions = work.wantedPartitions;
  options.iterations = static_cast<std::uint32_t>(this->NumberOfIterations);
  options.distanceWeight = this->DistanceWeight;
  options.compactnessWeight = this->CompactnessWeight;
  options.countWeight = this->CountWeight;
  work.Take(kdstream::ClusterByKMeans(work.points, work.triangles, options, work.execution));
}

void vtkKMeansPartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfIterations: " << this->NumberOfIterations << "\n";
  os << indent << "DistanceWeight: " << this->DistanceWeight << "\n";
  os << indent << "CompactnessWeight: " << this->CompactnessWeight << "\n";
  os << indent << "CountWeight: " << this->CountWeight << "\n";
}
