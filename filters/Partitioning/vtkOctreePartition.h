// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkOctreePartition
 * @brief   cuts a surface or point set into the leaves of an octree: equal cubes, unequal counts
 *
 * A baseline to compare vtkKdTreePartition with. A cube of more than VerticesPerPartition points is
 * split into eight equal ones; those that hold points are the partitions, in Morton order. The root
 * is the cube around the centre of the points' box with its longest side. Cubes of 1/2^21 of its
 * side are not split: so points that are nearer to each other may make a partition of more than
 * VerticesPerPartition.
 *
 * An octree does not give every number of partitions. If NumberOfPartitions is set, any number up
 * to that of the points, the VerticesPerPartition whose number of partitions is nearest is used
 * instead of yours (of two as near the one with fewer).
 *
 * Input, outputs, ghosts, errors: see vtkMeshPartition.
 *
 * Complexity: O(n d) for n points and leaves of depth d; 32 bytes a point.
 *
 * Source: sections 2.1 and 4.1.1 of the paper named in the README.
 *
 * @sa vtkKdTreePartition vtkKMeansPartition vtkPartitionMeasures
 */
#ifndef vtkOctreePartition_h
#define vtkOctreePartition_h

#include "vtkMeshPartition.h"

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkOctreePartition : public vtkMeshPartition
{
public:
  static vtkOctreePartition* New();
  vtkTypeMacro(vtkOctreePartition, vtkMeshPartition);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkOctreePartition() = default;
  ~vtkOctreePartition() override = default;

  void AssignPoints(kdstream::MeshPartitionWork& work) override;

private:
  vtkOctreePartition(const vtkOctreePartition&) = delete;
  void operator=(const vtkOctreePartition&) = delete;
};

#endif
