// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class vtkPCLSurfaceReconstruction
 * @brief makes a surface of a point cloud, by PCL
 *
 * Input: the points of a vtkPolyData; its cells are ignored. A composite data set of these is taken
 * as one cloud without ghosts, as vtkMeshPartition describes. There are two methods:
 *
 * Greedy (pcl::GreedyProjectionTriangulation) joins the points themselves. The output has the
 * input's points, bit for bit and in order, with their point data, and triangles between them. It
 * has holes where points are too far apart, and points that fit nowhere are in no triangle. This
 * method suits scans of even density.
 *
 * Poisson (pcl::Poisson) gives a surface near the points; it is closed if the points surround the
 * object. The surface has points of its own, each with the point data of the nearest input point.
 * This method suits noisy clouds; TrimDistance removes the parts that it adds where there are no
 * points.
 *
 * Both outputs have the point array "Normals" (3 floats, unit length, the active normals): for
 * greedy the normals that were used, for Poisson those of the surface. Triangles are
 * counter-clockwise if seen from the side to which the normals point.
 *
 * Normals: the input's active normals are used if they are finite and not zero. All other normals
 * are fitted to the nearest points (NumberOfNeighbors, or NormalRadius) by pcl::computePointNormal.
 * Then they are turned towards ViewPoint, or (default) so that neighbours agree. This begins at the
 * highest point (greatest z) of every part, whose normal points up.
 *
 * PCL works in floats. It gets the points relative to the centre of their box, so that large
 * offsets lose no precision. Points in one place count once.
 *
 * Without points, the output is empty. Errors, with an empty output: a coordinate that is not
 * finite; fewer than three points in different places; all points on one line; a part that is not a
 * vtkPolyData. GetErrorCode is then vtkErrorCode::UnknownError, else NoError.
 *
 * Complexity: O(n log n) for greedy; Poisson grows with the size of its surface. Memory: about 400
 * bytes a point. Neighbours and normals run on vtkSMPTools and can be aborted; PCL's own part is
 * serial and cannot be aborted. The result does not depend on the backend and the threads.
 *
 * In the setters below, numbers out of range are clamped. It is an error to set a negative number
 * where none is allowed, NaN, or a vector that is not finite; the old value then stays.
 *
 * Source: Marton, Rusu, Beetz: On Fast Surface Reconstruction Methods for Large and Noisy Datasets
 * (2009); Kazhdan, Bolitho, Hoppe: Poisson Surface Reconstruction (2006); Hoppe et al.: Surface
 * Reconstruction from Unorganized Points (1992) for the orientation of normals.
 */
#ifndef vtkPCLSurfaceReconstruction_h
#define vtkPCLSurfaceReconstruction_h

#include "vtkKdStreamFiltersPointCloudModule.h" // for the export macro
#include "vtkPolyDataAlgorithm.h"

class VTKKDSTREAMFILTERSPOINTCLOUD_EXPORT vtkPCLSurfaceReconstruction : public vtkPolyDataAlgorithm
{
public:
  static vtkPCLSurfaceReconstruction* New();
  vtkTypeMacro(vtkPCLSurfaceReconstruction, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum MethodType
  {
    GREEDY = 0,
    POISSON = 1
  };
  enum OrientationType
  {
    NEIGHBORS_AGREE = 0,
    TOWARDS_VIEWPOINT = 1
  };

  /**
   * The progress at which neighbours and normals are done and PCL begins. PCL reports no progress
   * until it has finished.
   */
  static constexpr double SurfaceProgress = 0.4;

  ///@{
  /**
   * How the surface is made. Default GREEDY.
   */
  vtkSetClampMacro(Method, int, GREEDY, POISSON);
  vtkGetMacro(Method, int);
  const char* GetMethodAsString() const;
  void SetMethodToGreedy() { this->SetMethod(GREEDY); }
  void SetMethodToPoisson() { this->SetMethod(POISSON); }
  ///@}

  ///@{
  /**
   * Whether the input's normals are used. Default on.
   */
  vtkSetMacro(UseInputNormals, bool);
  vtkGetMacro(UseInputNormals, bool);
  vtkBooleanMacro(UseInputNormals, bool);
  ///@}

  ///@{
  /**
   * The number of nearest points to which a tangent plane is fitted. 3 to 1000, default 16.
   */
  virtual void SetNumberOfNeighbors(int value);
  vtkGetMacro(NumberOfNeighbors, int);
  ///@}

  ///@{
  /**
   * If this is not 0, the tangent plane is fitted instead to all points within this radius, in the
   * input's unit, if there are at least three. Default 0.
   */
  virtual void SetNormalRadius(double value);
  vtkGetMacro(NormalRadius, double);
  ///@}

  ///@{
  /**
   * How fitted normals are turned. Default NEIGHBORS_AGREE.
   */
  vtkSetClampMacro(Orientation, int, NEIGHBORS_AGREE, TOWARDS_VIEWPOINT);
  vtkGetMacro(Orientation, int);
  const char* GetOrientationAsString() const;
  ///@}

  ///@{
  /**
   * Where the scanner stood, for TOWARDS_VIEWPOINT. Default the origin.
   */
  virtual void SetViewPoint(double x, double y, double z);
  virtual void SetViewPoint(const double value[3]);
  vtkGetVector3Macro(ViewPoint, double);
  ///@}

  ///@{
  /**
   * Greedy: the longest edge, in the input's unit. 0, the default: 2.25 times the spacing, which
   * is the median distance to the sixth nearest point.
   */
  virtual void SetSearchRadius(double value);
  vtkGetMacro(SearchRadius, double);
  ///@}

  ///@{
  /**
   * Greedy: the longest edge at a point, as a multiple of the distance to its nearest point; for
   * clouds of uneven density (PCL's advice is 2.5 to 3). 0, the default: only SearchRadius limits
   * edges.
   */
  virtual void SetMu(double value);
  vtkGetMacro(Mu, double);
  ///@}

  ///@{
  /**
   * Greedy: how many nearest points are examined. 3 to 10000, default 100.
   */
  virtual void SetMaximumNumberOfNeighbors(int value);
  vtkGetMacro(MaximumNumberOfNeighbors, int);
  ///@}

  ///@{
  /**
   * Greedy: points are not joined if their normals differ by more than this. Degrees, 0 to 180,
   * default 60.
   */
  virtual void SetMaximumSurfaceAngle(double value);
  vtkGetMacro(MaximumSurfaceAngle, double);
  ///@}

  ///@{
  /**
   * Greedy: the angles that triangles should have. Triangles with larger angles are not made; those
   * with smaller angles only if nothing else fits. Degrees, 0 to 180, default 10 and 120.
   */
  virtual void SetMinimumAngle(double value);
  vtkGetMacro(MinimumAngle, double);
  virtual void SetMaximumAngle(double value);
  vtkGetMacro(MaximumAngle, double);
  ///@}

  ///@{
  /**
   * Poisson: the depth of the octree, which has 2^Depth cells along a side. 0, the default: 6 to
   * 10, by the density of the points. At most 12: each further level takes four times the memory
   * and time.
   */
  virtual void SetDepth(int value);
  vtkGetMacro(Depth, int);
  ///@}

  ///@{
  /**
   * Poisson: the minimum number of points that a cell should have; a larger number smooths noise
   * away. 0.5 to 100, default 1.
   */
  virtual void SetSamplesPerNode(double value);
  vtkGetMacro(SamplesPerNode, double);
  ///@}

  ///@{
  /**
   * Poisson: how closely the surface follows the points; 0 is the method of 2006. 0 to 100, default
   * 4.
   */
  virtual void SetPointWeight(double value);
  vtkGetMacro(PointWeight, double);
  ///@}

  ///@{
  /**
   * Poisson: drops the triangles that are farther than this from every point, in spacings (see
   * SearchRadius). The surface is then no longer closed. 0, the default: drops none.
   */
  virtual void SetTrimDistance(double value);
  vtkGetMacro(TrimDistance, double);
  ///@}

  ///@{
  /**
   * Whether points in the same place become one, if they are in different parts of a composite
   * input. Used only if the input has no global ids. Points of one part are never joined. Default
   * off.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}

protected:
  vtkPCLSurfaceReconstruction();
  ~vtkPCLSurfaceReconstruction() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkPCLSurfaceReconstruction(const vtkPCLSurfaceReconstruction&) = delete;
  void operator=(const vtkPCLSurfaceReconstruction&) = delete;

  int Method = GREEDY;
  bool UseInputNormals = true;
  int NumberOfNeighbors = 16;
  double NormalRadius = 0;
  int Orientation = NEIGHBORS_AGREE;
  double ViewPoint[3] = { 0, 0, 0 };
  double SearchRadius = 0;
  double Mu = 0;
  int MaximumNumberOfNeighbors = 100;
  double MaximumSurfaceAngle = 60;
  double MinimumAngle = 10;
  double MaximumAngle = 120;
  int Depth = 0;
  double SamplesPerNode = 1;
  double PointWeight = 4;
  double TrimDistance = 0;
  bool WeldByPlace = false;
};

#endif
