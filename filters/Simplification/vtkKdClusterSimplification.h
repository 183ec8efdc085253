// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdClusterSimplification
 * @brief   one level of detail of a surface, by clusters or by edge collapse
 *
 * Step "levels" of the pipeline picture, as a VTK filter. It gives the levels that kdstream-build
 * makes with the same options.
 *
 * Input: a vtkPolyData; or a composite data set of them, which is taken as one mesh without ghosts
 * (vtkMeshPartition). A balanced k-d tree (as in vtkKdTreePartition) splits its points down to the
 * finest level, where all cells hold the same number of points, up to one. The points of a cell, or
 * of each connected sheet of the surface inside it, become one point. Coarser levels come from the
 * finest: by the cells above (Maker Cluster), or by edge collapse (Maker Collapse), which stays
 * much closer to the surface at the same number of triangles. Depth chooses the level, or
 * TargetNumberOfTriangles: the level with about that number.
 *
 * Any other clusters: name a point array of whole numbers with SetInputArrayToProcess(0, 0, 0,
 * vtkDataObject::FIELD_ASSOCIATION_POINTS, NAME), such as the PartitionId of vtkOctreePartition.
 * Points with the same number become one point, or one for each sheet. Tree, Maker, Depth and
 * TargetNumberOfTriangles do not matter then. An empty NAME goes back to the tree.
 *
 * Output: a vtkPolyData with the triangles of the input between the new points, degenerate ones
 * dropped, one kept of each orientation. By Depth it has about 2^Depth points. Points are float if
 * the input's are, else double. An input without triangles is a point set: its output has a vertex
 * cell for every point. Arrays:
 * - "Deviation" (point array, vtkDoubleArray): how far, in the input's unit, a point lies from the
 *   surface that it stands for: the root of the mean squared distance to the planes of its
 *   triangles, never less than that of the finer points that it is made from. An estimate: of parts
 *   that vanish it knows nothing.
 * - "Normals" (point data; three floats or doubles) and "RGB" or "RGBA" (colours: scalars of
 *   unsigned char): averages.
 * - Every other array of numbers keeps its name, and stays active if it was. Of point data it has
 *   the means of the points that became one; of cell data the means of the triangles that a
 *   triangle stands for (its own image, and those that vanished beside it). Of classes (arrays of
 *   one component that are bytes, or are called a class or a label) it has the most frequent one.
 *
 * Not passed: active global and pedigree ids, since different points are one now; vertex and line
 * cells; of a point set, cell data. Points that no triangle uses are dropped, as in a store, unless
 * clusters are given. Polygons become triangles (concave ones by cutting ears), strips triangles.
 * No points give an empty output.
 *
 * Complexity: O((n + t) log n) for n points and t triangles. Memory beside input and output: about
 * 150 bytes a point, 60 a triangle. Runs on vtkSMPTools; the result does not depend on backend and
 * threads. Aborting leaves an empty output. Errors, with an empty output: a coordinate that is not
 * finite; a cell that uses a point that is not there; points that span more than 2^127 along an
 * axis; Depth below the finest level; an array to process that is not there, or is not one whole
 * number for each point; a part that is not a vtkPolyData. GetErrorCode is then
 * vtkErrorCode::UnknownError, else NoError.
 *
 * Numbers below that are out of their range are clamped. A negative number where none is allowed,
 * or NaN, is an error, and the old value stays.
 *
 * Source: section 4.3 of the paper named in the README, exactly so with Maker Cluster, Sheets off
 * and Representative Mean; sheets, quadrics, collapse in rounds and geometric errors are ours.
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
    Quadric = 0, // minimises the distances to the planes of the cluster's triangles
    Mean = 1     // the mean of the cluster's points
  };

  enum MakerType // as vtkKdStoreWriter's
  {
    Collapse = 0, // by edge collapse from the finest level
    Cluster = 1   // by the cells of the tree
  };

  ///@{
  /**
   * How levels coarser than the finest are made: Collapse (0, default), the default of
   * kdstream-build and vtkKdStoreWriter too, or Cluster (1), which is faster and treats triangle
   * soups evenly. Point sets are always clustered.
   */
  vtkSetClampMacro(Maker, int, Collapse, Cluster);
  vtkGetMacro(Maker, int);
  const char* GetMakerAsString() const;
  void SetMakerToCluster() { this->SetMaker(Cluster); }
  void SetMakerToCollapse() { this->SetMaker(Collapse); }
  ///@}

  ///@{
  /**
   * The number of triangles wanted (of points, for a point set); 0, the default, chooses by Depth.
   * Maker Collapse gives at most this number, as near to it as it can; Maker Cluster gives the
   * level whose number is nearest. An input that has fewer gives its finest level.
   */
  virtual void SetTargetNumberOfTriangles(vtkIdType value);
  vtkGetMacro(TargetNumberOfTriangles, vtkIdType);
  ///@}

  ///@{
  /**
   * The level: about 2^Depth points. From 0, one point a sheet, to the depth of the finest level,
   * which depends on the input (see GetFinestDepth); a larger value is an error. -1, the default,
   * is the finest level. At most 30.
   */
  virtual void SetDepth(int value);
  vtkGetMacro(Depth, int);
  ///@}

  ///@{
  /**
   * Where the point of a cluster is put: Quadric (0, default) or Mean (1). Both stay in the box of
   * the cluster's points.
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
   * its own point; off: one point for each cell. Default on, so that two sides of a thin wall stay
   * apart.
   */
  vtkSetMacro(Sheets, bool);
  vtkGetMacro(Sheets, bool);
  vtkBooleanMacro(Sheets, bool);
  ///@}

  ///@{
  /**
   * Whether points with bit-equal coordinates, equal normals and colours, and the same cluster id,
   * are joined first. Default on: a surface read from STL has no connections otherwise.
   */
  vtkSetMacro(Weld, bool);
  vtkGetMacro(Weld, bool);
  vtkBooleanMacro(Weld, bool);
  ///@}

  ///@{
  /**
   * Whether points of different parts of a composite input that lie in the same place become one.
   * Used only where the input has no global ids. Points of one part are never joined. Default off:
   * Weld joins such points too, except where normals or colours differ.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}

  ///@{
  /**
   * The most points of a cell at the finest level, 1 to 1024; default 8.
   */
  virtual void SetCellVertices(int value);
  vtkGetMacro(CellVertices, int);
  ///@}

  ///@{
  /**
   * The most points of a partition, 1 to 2^31 - 1; default 2000. The finest level is at least as
   * deep as the partitions.
   */
  virtual void SetVerticesPerPartition(vtkIdType value);
  vtkGetMacro(VerticesPerPartition, vtkIdType);
  ///@}

  /**
   * The depth of the finest level of the last input; -1 before the first one, and where clusters
   * were given.
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

  bool HasClusters(); // whether an array of them was named

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
