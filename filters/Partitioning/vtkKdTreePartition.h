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
 * Several processes (Controller): their inputs are parts of one mesh, and all of them update
 * together: where the input of one alone has changed, the others call Modified first. Port 0 has all partitions of one tree over the whole mesh, of which each process gets
 * its part, from left to right in the tree, a subtree where their number is a power of two; the
 * others are null. They are those that one process would give of the whole mesh, to the bit: of the
 * points by ascending global ids where all processes have vtkDataSetAttributes::GetGlobalIds, and
 * what has the same id is one point; else of the points of process 0 first, and
 * nothing is one. Cells likewise: by global ids, or process by process. Ids that stand for points
 * further apart than 2^-20 of the diagonal, or for different cells, as where each process counts
 * its own, are not believed: they come along as a plain array. What vtkGhostType marks as another's
 * is not counted. Arrays of numbers come along that all processes with points (cells) have; others
 * are listed in a warning. Port 1 is this process's input.
 *
 * Sources that give pieces, as vtkKdStoreReader does, are asked for the process's own; what others
 * have is what this process has: a file of its own, say. Where that is the same mesh everywhere, a
 * warning tells. A process that has nothing of the mesh sets an empty vtkPolyData. An error of one
 * process is an error of all, which names it: no input or one of another type, that of its input,
 * other options than process 0 has, the end of its memory; GetErrorCode is then UnknownError.
 *
 * Complexity: O(n log n) for n points; 50 bytes a point. On several processes O(n) a depth of each
 * one's points, 12 or 24 sums over them of at most 8 MiB, and each point and cell is sent once to
 * each process that needs it.
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
   * or a single process: this one alone.
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
