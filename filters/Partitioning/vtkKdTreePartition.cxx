// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdTreePartition.h"

#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/core/tree/KdTree.h"

#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkKdTreePartition);

void vtkKdTreePartition::AssignPoints(kdstream::MeshPartitionWork& work)
{
  kdstream::KdTreeOptions options;
  options.verticesPerPartition = work.verticesPerPartition;
  options.partitions = work.wantedPartitions;
  options.cellVertices = 0;
  const auto tree = kdstream::BuildKdTree(work.points, options, work.execution);
  if (!tree)
  {
    work.status = tree.GetError();
    return;
  }
  work.partitionOf = kdstream::CellOfVertex(*tree, tree->depths.partition);
  work.partitions = std::size_t{ 1 } << tree->depths.partition;
}

void vtkKdTreePartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
