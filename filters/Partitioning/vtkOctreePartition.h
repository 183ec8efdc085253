// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkOctreePartition
 * @brief   cuts a surface or point set into the leaves of an octree: equal cubes, unequal counts
 *
 * A baseline for comparison with vtkKdTreePartition. A cube of more than VerticesPerPartition
 * points is split into eight equal cubes; those that contain points are the partitions, in Morton
 * order. The root is a cube: it has the centre of the points' box, and its longest side. Cubes with
 * 1/2^21 of the root's side are not split. So points that are nearer to each other may form a
 * partition of more than VerticesPerPartition.
 *
 * An octree cannot give every number of partitions. NumberOfPartitions may be any number up to that
 * of the points. If it is set, VerticesPerPartition is ignored; instead the value is used that
 * gives the nearest number of partitions (if two are as near, the one with fewer).
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
