// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkPartitionMeasures
 * @brief   tables of the sizes, boundaries, areas and compactness of the partitions of a surface
 *
 * Input: a vtkPolyData with a point array of one component: the partition of each point, as whole
 * numbers of any numeric type. The default is "PartitionId", which is in port 1 of
 * vtkKdTreePartition, vtkOctreePartition and vtkKMeansPartition (GeneratePartitionIdsOn). Choose
 * another array with SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS,
 * name). Composite data sets, such as port 0 of these filters, are treated as one mesh without
 * ghosts (vtkMeshPartition).
 *
 * Output port 0: a vtkTable with a row for each number in the array, ascending:
 *
 * - PartitionId (vtkIdType);
 * - Vertices, Triangles, OwnTriangles (vtkIdType): its points; the triangles that touch one of its
 *   points; and those of them that no partition of a lower number touches;
 * - BoundaryLength, Area (double, in the unit of the points): of the triangles that touch it; the
 *   boundary consists of the edges that only one of them has;
 * - Compactness (double): p^2 / (4 pi w) for boundary p and area w. A disc has 1, a square cut
 *   along edges about 1.5; lower is better. NaN without area or without boundary.
 *
 * Output port 1: a vtkTable with one row: Partitions, Measured (vtkIdType; how many have a
 * compactness), and Minimum, Maximum, Mean, StandardDeviation and Ratio (maximum divided by
 * minimum) of Vertices, Triangles and Compactness (double), named "VerticesMinimum" and so on.
 *
 * Polygons and strips become triangles; vertices and lines are ignored. Points in one place count
 * as one for edges. Without points there are no rows, and zeros in port 1.
 *
 * Complexity: O(n log n + t log t) for n points and t triangles; about 60 bytes a point, 60 a
 * triangle. Serial. Aborting leaves empty outputs. Errors, with empty outputs: no such array, or
 * not one value for each point; a value that is not a whole number; a coordinate that is not
 * finite; a cell that uses a missing point; a part that is not a vtkPolyData. GetErrorCode is then
 * vtkErrorCode::UnknownError, otherwise NoError.
 *
 * Source: eq. (1) and section 4.1.1 of the paper named in the README.
 *
 * @sa vtkMeshPartition
 */
#ifndef vtkPartitionMeasures_h
#define vtkPartitionMeasures_h

#include "vtkKdStreamFiltersPartitioningModule.h" // for the export macro
#include "vtkTableAlgorithm.h"

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkPartitionMeasures : public vtkTableAlgorithm
{
public:
  static vtkPartitionMeasures* New();
  vtkTypeMacro(vtkPartitionMeasures, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Whether points of different parts of a composite input that are in the same place become one.
   * Used only if the input has no global ids. Points of one part are never joined. Default off.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}

protected:
  vtkPartitionMeasures();
  ~vtkPartitionMeasures() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkPartitionMeasures(const vtkPartitionMeasures&) = delete;
  void operator=(const vtkPartitionMeasures&) = delete;

  bool WeldByPlace = false;
};

#endif
