/**
 * @class   vtkKdTreePartition
 * @brief   cuts a surface or point set into uniform partitions along a balanced k-d tree
 *
 * Step "tree" of the README's picture, as a VTK filter.
 *
 * Input: a vtkPolyData. Its points are split at the median along the longest side of their bounding
 * box, again and again, until every partition has at most VerticesPerPartition of them. Points are
 * ordered by (coordinate, id), so that partitions differ by at most one point whatever the input:
 * flat plates and points repeated many times too.
 *
 * Output port 0: a vtkPartitionedDataSet with 2^P vtkPolyData. A cell goes to every partition that
 * one of its points belongs to, so that the boundary is whole on both sides: partitions can be
 * processed on their own. What is repeated is marked in vtkGhostType: a cell that a partition of a
 * lower number owns is DUPLICATECELL; a point that belongs to another partition is DUPLICATEPOINT.
 * The cells without this mark are, over all partitions, each cell of the input once. In a partition
 * its own points come first, in the input's order, then the ghosts. Points keep their type, bit for
 * bit. Point and cell data are passed; global cell ids only if no cell had to be cut up. Marks of a
 * vtkGhostType array in the input stay set.
 *
 * Output port 1: the input, with the array "PartitionId" if GeneratePartitionIds is on.
 *
 * Polygons become fans around their first point (put a vtkTriangleFilter before, if they are not
 * convex), strips triangles, polylines segments, poly-vertices single vertices; each gets the data
 * of its cell. Degenerate triangles are kept. Coincident points are not merged (see
 * vtkCleanPolyData).
 *
 * No points give no partitions. With more partitions than points some are empty.
 *
 * Complexity: O(n log n) for n points, linear in cells. Memory beside input and outputs: about 80
 * bytes a point and 30 a triangle. Runs on vtkSMPTools; the result does not depend on backend and
 * threads. Aborting leaves empty outputs. Errors, with empty outputs: a coordinate that is not
 * finite; a cell that uses a point that is not there; NumberOfPartitions that is no power of two or
 * above the number of points.
 *
 * Source: section 4.1 of the paper named in the README; the total order is ours.
 *
 * @sa vtkKdClusterSimplification
 */
#ifndef vtkKdTreePartition_h
#define vtkKdTreePartition_h

#include "vtkKdStreamFiltersPartitioningModule.h" // for the export macro
#include "vtkPartitionedDataSetAlgorithm.h"

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkKdTreePartition
  : public vtkPartitionedDataSetAlgorithm
{
public:
  static vtkKdTreePartition* New();
  vtkTypeMacro(vtkKdTreePartition, vtkPartitionedDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * The input, without a pipeline that makes it.
   */
  void SetInputData(vtkDataObject* input) { this->SetInputDataObject(0, input); }

  ///@{
  /**
   * The most points of a partition, ghosts not counted. At least 1, at most 2^31 - 1; default 2000.
   * Not used if NumberOfPartitions is set.
   */
  vtkSetClampMacro(VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX);
  vtkGetMacro(VerticesPerPartition, vtkIdType);
  ///@}

  ///@{
  /**
   * The number of partitions: a power of two, at most the number of points. 0, the default, chooses
   * by VerticesPerPartition. At most 2^30.
   */
  vtkSetClampMacro(NumberOfPartitions, vtkIdType, 0, 1 << 30);
  vtkGetMacro(NumberOfPartitions, vtkIdType);
  ///@}

  ///@{
  /**
   * Whether both outputs get the point array "PartitionId" (vtkIdTypeArray): the number of the
   * partition that a point belongs to, which for a ghost is another one. Default off.
   */
  vtkSetMacro(GeneratePartitionIds, bool);
  vtkGetMacro(GeneratePartitionIds, bool);
  vtkBooleanMacro(GeneratePartitionIds, bool);
  ///@}

protected:
  vtkKdTreePartition();
  ~vtkKdTreePartition() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkKdTreePartition(const vtkKdTreePartition&) = delete;
  void operator=(const vtkKdTreePartition&) = delete;

  vtkIdType VerticesPerPartition = 2000;
  vtkIdType NumberOfPartitions = 0;
  bool GeneratePartitionIds = false;
};

#endif
