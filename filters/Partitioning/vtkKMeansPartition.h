// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKMeansPartition
 * @brief   cuts a surface or point set by k-means clustering along the surface
 *
 * A baseline for comparison with vtkKdTreePartition. NumberOfPartitions clusters grow from seeds
 * along the edges of the triangles; the cheapest point is always next. (If NumberOfPartitions is 0,
 * it is the number of points divided by VerticesPerPartition, rounded up. So partitions have at
 * most VerticesPerPartition points on average, and some have more.) The cost of a point is a
 * weighted sum of its distance from the seed along edges, of compactness (the share of its
 * neighbours outside the cluster), and of the number of points in the cluster. Then the point in
 * the middle of a cluster becomes its next seed; this is done NumberOfIterations times.
 * Hierarchical face clustering spreads the first seeds; nothing is random.
 *
 * The number of partitions is exact. None is empty, and they are numbered by their first points.
 * Points that no seed reaches along edges (in small components) join the seed nearest in space.
 * Without triangles this is Lloyd's k-means. Coincident points count as connected.
 *
 * A number outside its range is clamped. But a negative number where none is allowed, or NaN, is an
 * error, and the old value stays.
 *
 * Input, outputs, ghosts, errors: see vtkMeshPartition.
 *
 * Complexity: O(t log^2 t) for the seeds among t triangles, O((n + t) log n) an iteration; 200
 * bytes a point and 200 a triangle. Serial, except for making the outputs.
 *
 * Source: section 4.1.1 of the paper named in the README. kdstream::ClusterByKMeans describes the
 * costs.
 *
 * @sa vtkKdTreePartition vtkOctreePartition vtkPartitionMeasures
 */
#ifndef vtkKMeansPartition_h
#define vtkKMeansPartition_h

#include "vtkMeshPartition.h"

class VTKKDSTREAMFILTERSPARTITIONING_EXPORT vtkKMeansPartition : public vtkMeshPartition
{
public:
  static vtkKMeansPartition* New();
  vtkTypeMacro(vtkKMeansPartition, vtkMeshPartition);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * How often clusters grow: 1 to 1000; default 5, as in the paper.
   */
  virtual void SetNumberOfIterations(int value);
  vtkGetMacro(NumberOfIterations, int);
  ///@}

  ///@{
  /**
   * The weight of the distance from the seed, in radii of a mean cluster. 10^-6 to 10^6; default 1.
   */
  virtual void SetDistanceWeight(double value);
  vtkGetMacro(DistanceWeight, double);
  ///@}

  ///@{
  /**
   * The weight of compactness: a larger weight gives straighter boundaries. 0 to 10^6; default 4.
   */
  virtual void SetCompactnessWeight(double value);
  vtkGetMacro(CompactnessWeight, double);
  ///@}

  ///@{
  /**
   * The weight of the number of points: a larger weight gives clusters of more equal sizes. 0 to
   * 10^6; default 1.
   */
  virtual void SetCountWeight(double value);
  vtkGetMacro(CountWeight, double);
  ///@}

protected:
  vtkKMeansPartition() = default;
  ~vtkKMeansPartition() override = default;

  void AssignPoints(kdstream::MeshPartitionWork& work) override;
  bool UsesCells() const override { return true; }

private:
  vtkKMeansPartition(const vtkKMeansPartition&) = delete;
  void operator=(const vtkKMeansPartition&) = delete;

  int NumberOfIterations = 5;
  double DistanceWeight = 1;
  double CompactnessWeight = 4;
  double CountWeight = 1;
};

#endif
