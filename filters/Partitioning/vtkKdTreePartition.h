// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTreePartition
 * @brief   cuts a surface or point set into uniform partitions along a balanced k-d tree
 *
 * Points are split at the median along the longest side of their bounding box, again and again,
 * until every partition has at most VerticesPerPartition of them. Points are ordered by
 * (coordinate, id). So the sizes of partitions differ by at most one point for any input, also for
 * flat plates and points repeated many times. The number of partitions is a power of two; another
 * NumberOfPartitions is an error. With more partitions than points some are empty.
 *
 * Input, outputs, ghosts, other errors: see vtkMeshPartition.
 *
 * Several processes (Controller): their inputs are parts of one mesh, and all of them update
 * together. Where only the input of one has changed, the others call Modified first.
 *
 * Port 0 has all partitions of one tree over the whole mesh; the partitions of other processes are
 * null. Each process gets its part, from left to right in the tree, a subtree where the number of
 * processes is a power of two. The partitions are those that one process would give of the whole
 * mesh, to the bit:
 * - If all processes have vtkDataSetAttributes::GetGlobalIds, points are in the order of global
 *   ids, and points of one id are one point. Else the points of process 0 come first, and no points
 *   are joined. Cells likewise.
 * - Ids are ignored, and passed as a plain array, if one id stands for points further apart than
 *   2^-20 of the diagonal, or for different cells, as where each process counts by itself.
 * - Points and cells that vtkGhostType marks as another process's do not count.
 * - Arrays of numbers are passed if all processes with points (cells) have them; a warning lists
 *   others.
 *
 * Port 1 is this process's input.
 *
 * Sources that give pieces, such as vtkKdStoreReader, are asked for the process's own piece. Other
 * sources give what this process has, such as a file of its own; a warning says if that is the same
 * mesh everywhere. A process that has nothing of the mesh sets an empty vtkPolyData. An error of
 * one process is an error of all, which names it: no input or one of another type, an error of its
 * input, other options than process 0, no memory left. GetErrorCode is then UnknownError.
 *
 * Complexity: O(n log n) for n points; 50 bytes a point. On several processes, for each depth: O(n)
 * for a process's n points, and 12 or 24 sums over the processes of at most 8 MiB. Each point and
 * cell is sent once to each process that needs it.
 *
 * Source: section 4.1 of the paper named in the README; the total order is ours.
 *
 * @sa vtkOctreePartition vtkKMeansPartition vtkKdClusterSimplification
 */
#ifndef vtkKdTreePartition_h
#define vtkKdTreePartition_h

#include "vtkMeshPartition.h"

class vtkMultiProcessController;

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkKdTreePartition : public vtkMeshPartition
{
public:
  static vtkKdTreePartition* New();
  vtkTypeMacro(vtkKdTreePartition, vtkMeshPartition);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The processes that cut one mesh together. Default: vtkMultiProcessController's global one; null
   * or a single process: only this one.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

protected:
  vtkKdTreePartition();
  ~vtkKdTreePartition() override;

  vtkExecutive* CreateDefaultExecutive() override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

  void AssignPoints(kdstream::MeshPartitionWork& work) override;

private:
  vtkKdTreePartition(const vtkKdTreePartition&) = delete;
  void operator=(const vtkKdTreePartition&) = delete;

  vtkMultiProcessController* Controller = nullptr;
};

#endif
