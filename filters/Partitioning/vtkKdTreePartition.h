// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTreePartition
 * @brief   cuts a surface or point set into uniform partitions along a balanced k-d tree
 *
 * Points are split at the median along the longest side of their bounding box, again and again,
 * until every partition has at most VerticesPerPartition points. Points are ordered by (coordinate,
 * id). So the sizes of partitions differ by at most one point for any input, even for flat plates
 * and points repeated many times. The number of partitions is a power of two; any other
 * NumberOfPartitions is an error. If there are more partitions than points, some are empty.
 *
 * Input, outputs, ghosts, other errors: see vtkMeshPartition.
 *
 * Several processes (Controller): their inputs are parts of one mesh, and all of them update
 * together. If the input of only one process has changed, the others must call Modified first.
 *
 * Port 0 has all partitions of one tree over the whole mesh; the partitions of other processes are
 * null. Partitions are distributed from left to right in the tree; if the number of processes is a
 * power of two, each process gets a subtree. The partitions are, to the bit, those that one process
 * would make of the whole mesh:
 * - If all processes have vtkDataSetAttributes::GetGlobalIds, points are in the order of global
 *   ids, and points with the same id are one point. Otherwise the points of process 0 come first,
 *   and no points are joined. The same goes for cells.
 * - Ids are ignored, and passed as a plain array, if one id stands for points further apart than
 *   2^-20 of the diagonal, or for different cells. This happens if each process counts its own
 *   points.
 * - Points and cells that vtkGhostType marks as belonging to another process do not count.
 * - Arrays of numbers are passed if all processes with points (or cells) have them; a warning lists
 *   others.
 * Port 1 is this process's input.
 *
 * Sources that deliver pieces, such as vtkKdStoreReader, are requested to deliver the process's own
 * piece. Other sources deliver what this process has, such as a file of its own; a warning says if
 * that is the same mesh on all processes. A process that has no part of the mesh sets an empty
 * vtkPolyData. An error of one process is an error of all, and names the process: no input, or one
 * of another type; an error of its input; other options than process 0; not enough memory.
 * GetErrorCode is then UnknownError.
 *
 * Complexity: O(n log n) for n points; 50 bytes a point. On several processes, for each depth: O(n)
 * for the n points of a process, and 12 or 24 sums over the processes of at most 8 MiB. Each point
 * and cell is sent once to each process that needs it.
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
   * The processes that cut one mesh together. Default: the global controller of
   * vtkMultiProcessController. Null or a single process: only this process.
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
