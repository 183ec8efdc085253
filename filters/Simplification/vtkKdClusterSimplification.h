// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdClusterSimplification
 * @brief   one level of detail of a surface, by clusters or by edge collapse
 *
 * Step "levels" of the pipeline picture, as a VTK filter. It gives the levels that kdstream-build
 * makes with the same options.
 *
 * Input: a vtkPolyData; or a composite data set of them, which is treated as one mesh without
 * ghosts (vtkMeshPartition). A balanced k-d tree (as in vtkKdTreePartition) splits its points down
 * to the finest level, where the numbers of points in the cells differ by at most one. The points
 * of a cell, or of each connected sheet of the surface inside it, become one point. Coarser levels
 * are made from the finest one: from the cells above (Maker Cluster), or by edge collapse (Maker
 * Collapse), which stays much closer to the surface with the same number of triangles. Choose the
 * level by Depth, or by TargetNumberOfTriangles: the level with about that number.
 *
 * You can also give clusters of your own: name a point array of whole numbers with
 * SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, NAME), such as the
 * PartitionId of vtkOctreePartition. Points with the same number become one point, or one point for
 * each sheet. Tree, Maker, Depth and TargetNumberOfTriangles then have no effect. An empty NAME
 * returns to the tree.
 *
 * Output: a vtkPolyData with the triangles of the input between the new points. Degenerate
 * triangles are dropped; of equal ones, one of each orientation is kept. By Depth it has about
 * 2^Depth points. Points are float if the input's are, otherwise double. An input without triangles
 * is a point set: its output has a vertex cell for every point. Arrays:
 * - "Deviation" (point array, vtkDoubleArray): how far, in the input's unit, a point is from the
 *   surface that it represents: the root of the mean squared distance to the planes of its
 *   triangles, never less than that of the finer points that it is made from. It is an estimate,
 *   and does not include parts that vanish.
 * - "Normals" (point data; three floats or doubles) and "RGB" or "RGBA" (colours: scalars of
 *   unsigned char): averages.
 * - Every other array of numbers keeps its name, and stays active if it was. For point data it has
 *   the means over the points that became one. For cell data it has the means over the triangles
 *   that a triangle represents (those that it is the image of, and those that vanished beside it).
 *   For classes (arrays of one component that are bytes, or whose name says class or label) it has
 *   the most frequent one.
 *
 * Not passed: active global and pedigree ids, because different points are now one; vertex and line
 * cells; cell data of a point set. Points that no triangle uses are dropped, as in a store, unless
 * clusters are given. Polygons become triangles (concave ones by cutting ears); strips become
 * triangles. If there are no points, the output is empty.
 *
 * Complexity: O((n + t) log n) for n points and t triangles. Memory besides input and output: about
 * 150 bytes a point, 60 a triangle. Runs on vtkSMPTools; the result does not depend on backend and
 * threads. Aborting leaves an empty output. Errors, with an empty output: a coordinate that is not
 * finite; a cell that uses a missing point; points that span more than 2^127 along an axis; Depth
 * below the finest level; an array to process that does not exist, or is not one whole number for
 * each point; a part that is not a vtkPolyData. GetErrorCode is then vtkErrorCode::UnknownError,
 * otherwise NoError.
 *
 * A number outside its range is clamped. But a negative number where none is allowed, or NaN, is an
 * error, and the old value stays.
 *
 * Source: section 4.3 of the paper named in the README. With Maker Cluster, Sheets off and
 * Representative Mean the method is exactly that of the paper; sheets, quadrics, collapse in rounds
 * and geometric errors are ours.
 *
 * @sa vtkKdTreePartition vtkOctreePartition vtkKMeansPartition
 */
#ifndef vtkKdClusterSimplification_h
#define vtkKdClusterSimplification_h

#include "vtkKdStreamFiltersSimplificationModule.h" // for the export macro
#include "vtkPolyDataAlgorithm.h"

class VTKKDSTREAMFILTERSSIMPLIFICATION_EXPORT vtkKdClusterSimplification
  : public vtkPolyDataAlgorithm
{
public:
  static vtkKdClusterSimplification* New();
  vtkTypeMacro(vtkKdClusterSimplification, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum RepresentativeType
  {
    Quadric = 0, // minimizes the distances to the planes of the cluster's triangles
    Mean = 1     // the mean of the cluster's points
  };

  enum MakerType // as in vtkKdStoreWriter
  {
    Collapse = 0, // by edge collapse from the finest level
    Cluster = 1   // by the cells of the tree
  };

  ///@{
  /**
   * How levels coarser than the finest are made. Collapse (0) is the default here, in
   * kdstream-build and in vtkKdStoreWriter. Cluster (1) is faster, and treats triangle soups
   * evenly. Point sets are always clustered.
   */
  vtkSetClampMacro(Maker, int, Collapse, Cluster);
  vtkGetMacro(Maker, int);
  const char* GetMakerAsString() const;
  void SetMakerToCluster() { this->SetMaker(Cluster); }
  void SetMakerToCollapse() { this->SetMaker(Collapse); }
  ///@}

  ///@{
  /**
   * The wanted number of triangles (of points, for a point set); 0, the default, means: by Depth.
   * Maker Collapse gives at most this number, as near to it as possible; Maker Cluster gives the
   * level whose number is nearest. If the input has fewer, the result is its finest level.
   */
  virtual void SetTargetNumberOfTriangles(vtkIdType value);
  vtkGetMacro(TargetNumberOfTriangles, vtkIdType);
  ///@}

  ///@{
  /**
   * The level: about 2^Depth points. It ranges from 0, which has one point for each sheet, to the
   * depth of the finest level, which depends on the input (see GetFinestDepth); a larger value is
   * an error. -1, the default, is the finest level. At most 30.
   */
  virtual void SetDepth(int value);
  vtkGetMacro(Depth, int);
  ///@}

  ///@{
  /**
   * Where the point of a cluster is placed: Quadric (0, default) or Mean (1). Both stay within the
   * box of the cluster's points.
   */
  vtkSetClampMacro(Representative, int, Quadric, Mean);
  vtkGetMacro(Representative, int);
  const char* GetRepresentativeAsString() const;
  void SetRepresentativeToQuadric() { this->SetRepresentative(Quadric); }
  void SetRepresentativeToMean() { this->SetRepresentative(Mean); }
  ///@}

  ///@{
  /**
   * Whether every sheet of the surface in a cell (at most four; smaller ones join the nearest) gets
   * its own point; off: one point for each cell. Default on, so that the two sides of a thin wall
   * stay separate.
   */
  vtkSetMacro(Sheets, bool);
  vtkGetMacro(Sheets, bool);
  vtkBooleanMacro(Sheets, bool);
  ///@}

  ///@{
  /**
   * Whether points with bit-equal coordinates, equal normals and colours, and the same cluster id
   * are joined first. Default on: otherwise a surface read from STL would not be connected.
   */
  vtkSetMacro(Weld, bool);
  vtkGetMacro(Weld, bool);
  vtkBooleanMacro(Weld, bool);
  ///@}

  ///@{
  /**
   * Whether points of different parts of a composite input that are in the same place become one.
   * Used only if the input has no global ids. Points of one part are never joined. Default off:
   * Weld joins such points too, except where normals or colours differ.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}

  ///@{
  /**
   * The maximum number of points in a cell of the finest level, 1 to 1024; default 8.
   */
  virtual void SetCellVertices(int value);
  vtkGetMacro(CellVertices, int);
  ///@}

  ///@{
  /**
   * The maximum number of points in a partition, 1 to 2^31 - 1; default 2000. The finest level is
   * at least as deep as the partitions.
   */
  virtual void SetVerticesPerPartition(vtkIdType value);
  vtkGetMacro(VerticesPerPartition, vtkIdType);
  ///@}

  /**
   * The depth of the finest level of the last input; -1 before the first input, or if clusters were
   * given.
   */
  vtkGetMacro(FinestDepth, int);

protected:
  vtkKdClusterSimplification() = default;
  ~vtkKdClusterSimplification() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkKdClusterSimplification(const vtkKdClusterSimplification&) = delete;
  void operator=(const vtkKdClusterSimplification&) = delete;

  bool HasClusters(); // whether an array of clusters was named

  int Maker = Collapse;
  vtkIdType TargetNumberOfTriangles = 0;
  int Depth = -1;
  int Representative = Quadric;
  bool Sheets = true;
  bool Weld = true;
  bool WeldByPlace = false;
  int CellVertices = 8;
  vtkIdType VerticesPerPartition = 2000;
  int FinestDepth = -1;
};

#endif
