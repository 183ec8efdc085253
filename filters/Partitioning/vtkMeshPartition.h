// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMeshPartition
 * @brief   base class of the filters that cut a surface or point set into partitions
 *
 * Step "tree" of the pipeline picture, as VTK filters: vtkKdTreePartition, and the baselines
 * vtkOctreePartition and vtkKMeansPartition. They differ in which points make a partition: see
 * their pages. This page describes what they have in common.
 *
 * Input: a vtkPolyData, with or without cells; or a vtkPartitionedDataSet,
 * vtkPartitionedDataSetCollection or vtkMultiBlockDataSet of them, which is treated as one mesh:
 * - Points that parts share become one by their global ids, or by place if WeldByPlace is on. If
 *   points in different places share an id, ids are not used; a warning says so.
 * - Ghosts (vtkGhostType: duplicate, hidden, refined) are dropped. If a cell uses a duplicate
 *   point, it then uses the point that this is a copy of.
 * - Arrays that not all parts have, or that have a wrong length, are omitted with a warning.
 *
 * So the output of one of these filters can be the input of the next, as one mesh.
 *
 * Output port 0: a vtkPartitionedDataSet of vtkPolyData. A cell goes to every partition that owns
 * one of its points. So the boundary is complete on both sides, and each partition can be processed
 * separately. vtkGhostType marks repetitions: a cell that a partition of a lower number owns is
 * DUPLICATECELL; a point that belongs to another partition is DUPLICATEPOINT. The unmarked cells of
 * all partitions are the cells of the input, each once. In a partition its own points come first,
 * in the input's order, then the ghosts. Points keep their type, bit for bit. Point and cell data
 * are passed; global cell ids only if no cell had to be split.
 *
 * Output port 1: the input as one mesh, with the array "PartitionId" if GeneratePartitionIds is on.
 * It can be the input of vtkPartitionMeasures. If only this port is updated, nothing is cut: the
 * cost is the time of the partitioner, and 24 bytes a point while it runs.
 *
 * Polygons become triangles (concave ones by cutting ears), strips become triangles, polylines
 * segments, poly-vertices single vertices; each gets the data of its cell. Degenerate triangles are
 * kept. Coincident points are not merged (see vtkCleanPolyData). Points that no cell uses are
 * ordinary points. A store sets such points aside; so only for a mesh without them, its partitions
 * are the same as here.
 *
 * No points give no partitions.
 *
 * Complexity: that of the partitioner, and linear in points and cells. Memory besides input,
 * outputs and partitioner: about 30 bytes a point and 30 a triangle. Runs on vtkSMPTools; the
 * result does not depend on backend and threads. Aborting leaves empty outputs. Errors, with empty
 * outputs: a coordinate that is not finite; a cell that uses a missing point, or whose corners are
 * beyond the end of its vtkCellArray; points that span more than 2^127 along an axis;
 * NumberOfPartitions above the number of points; a part that is not a vtkPolyData. GetErrorCode is
 * then vtkErrorCode::UnknownError, otherwise NoError.
 *
 * A number outside its range is clamped. But a negative number where none is allowed, or NaN, is an
 * error, and the old value stays.
 *
 * Not intended for subclasses outside this module: the data for a partitioner are not public.
 *
 * @sa vtkKdTreePartition vtkOctreePartition vtkKMeansPartition vtkPartitionMeasures
 */
#ifndef vtkMeshPartition_h
#define vtkMeshPartition_h

#include "vtkKdStreamFiltersPartitioningModule.h" // for the export macro
#include "vtkPartitionedDataSetAlgorithm.h"

#include <memory> // for whose the points are

namespace kdstream
{
struct MeshPartitionWork;
struct PartitionAssignment;
}

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkMeshPartition : public vtkPartitionedDataSetAlgorithm
{
public:
  vtkTypeMacro(vtkMeshPartition, vtkPartitionedDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Sets the input directly, without a pipeline.
   */
  void SetInputData(vtkDataObject* input) { this->SetInputDataObject(0, input); }

  ///@{
  /**
   * The size of partitions, not counting ghosts: the subclass says whether it is a maximum or an
   * average. At least 1, at most 2^31 - 1; default 2000. Not used if NumberOfPartitions is set.
   */
  virtual void SetVerticesPerPartition(vtkIdType value);
  vtkGetMacro(VerticesPerPartition, vtkIdType);
  ///@}

  ///@{
  /**
   * The number of partitions, at most the number of points: the subclass says which numbers are
   * possible. 0, the default, chooses by VerticesPerPartition. At most 2^30.
   */
  virtual void SetNumberOfPartitions(vtkIdType value);
  vtkGetMacro(NumberOfPartitions, vtkIdType);
  ///@}

  ///@{
  /**
   * Whether both outputs get the point array "PartitionId" (vtkIdTypeArray): the number of the
   * partition that owns each point (for a ghost point, another partition). Default off.
   */
  vtkSetMacro(GeneratePartitionIds, bool);
  vtkGetMacro(GeneratePartitionIds, bool);
  vtkBooleanMacro(GeneratePartitionIds, bool);
  ///@}

  ///@{
  /**
   * Whether points of different parts of a composite input that are in the same place become one.
   * Used only if the input has no global ids. Points of one part are never joined. Default off.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}
  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

protected:
  vtkMeshPartition();
  ~vtkMeshPartition() override;

  /**
   * Gives each point its partition. There is at least one point.
   */
  virtual void AssignPoints(kdstream::MeshPartitionWork& work) = 0;

  /**
   * Whether AssignPoints uses triangles.
   */
  virtual bool UsesCells() const { return false; }

  /**
   * Whether a request is for port 0; then partitions have to be cut.
   */
  static bool AsksForPartitions(vtkInformation* request);

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkMeshPartition(const vtkMeshPartition&) = delete;
  void operator=(const vtkMeshPartition&) = delete;

  struct Run;

  vtkIdType VerticesPerPartition = 2000;
  vtkIdType NumberOfPartitions = 0;
  bool GeneratePartitionIds = false;
  bool WeldByPlace = false;
  std::unique_ptr<kdstream::PartitionAssignment> Assigned; // until port 0 has been made from it
};

#endif
