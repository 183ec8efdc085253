// SPDX-License-Identifier: BSD-3-Clause
#include "vtkOctreePartition.h"

#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/baselines/OctreeClustering.h"

#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkOctreePartition);

void vtkOctreePartition::AssignPoints(kdstream::MeshPartitionWork& work)
{
  work.Take(kdstream::ClusterByOctree(
    work.points, { work.verticesPerPartition, work.wantedPartitions }, work.execution));
}

void vtkOctreePartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
