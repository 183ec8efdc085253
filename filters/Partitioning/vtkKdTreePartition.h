// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTreePartition
 * @brief   cuts a surface or point set into uniform partitions along a balanced k-d tree
 *
 * Points are split at the median along the longest side of their bounding box, again and again,
 * until every partition has at most VerticesPerPartition of them. Points are ordered by
 * (coordinate, id), so that partitions differ by at most one point whatever the input: flat plates
 * and points repeated many times too. Their number is a power of two; NumberOfPartitions that is
 * none is an error. With more partitions than points some are empty.
 *
 * Input, outputs, ghosts, other errors: see vtkMeshPartition.
 *
 * Complexity: O(n log n) for n points; 50 bytes a point.
 *
 * Source: section 4.1 of the paper named in the README; the total order is ours.
 *
 * @sa vtkOctreePartition vtkKMeansPartition vtkKdClusterSimplification
 */
#ifndef vtkKdTreePartition_h
#define vtkKdTreePartition_h

#include "vtkMeshPartition.h"

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkKdTreePartition : public vtkMeshPartition
{
public:
  static vtkKdTreePartition* New();
  vtkTypeMacro(vtkKdTreePartition, vtkMeshPartition);
  void PrintSelf(ostream& os, vtkIndent indent) override;

protected:
  vtkKdTreePartition() = default;
  ~vtkKdTreePartition() override = default;

  void AssignPoints(kdstream::MeshPartitionWork& work) override;

private:
  vtkKdTreePartition(const vtkKdTreePartition&) = delete;
  void operator=(const vtkKdTreePartition&) = delete;
};

#endif
