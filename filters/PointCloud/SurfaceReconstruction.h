// SPDX-License-Identifier: BSD-3-Clause
// Fits a surface through or near a point cloud, by PCL: the work of vtkPCLSurfaceReconstruction,
// without VTK.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

struct ReconstructionOptions
{
  enum class Method
  {
    Greedy, // joins the points to triangles; leaves holes where points are far apart
    Poisson // a closed surface near the points
  };
  Method method = Method::Greedy;

  // Options for the normals of points that have none.
  std::uint32_t neighbors = 16;  // how many nearest points define a tangent plane; at least 3
  double normalRadius = 0;       // instead all points this near, if at least 3
  bool towardsViewpoint = false; // else neighbours agree (OrientNormals)
  Vec3 viewpoint{};

  // Options of Greedy.
  double searchRadius = 0; // longest edge; 0: from the points' spacing
  double mu = 0;           // longest edge, in distances to the nearest point; 0: no limit
  std::uint32_t maximumNeighbors = 100;         // nearest points to examine
  double maximumSurfaceAngle = 60;              // degrees between neighbours' normals
  double minimumAngle = 10, maximumAngle = 120; // of triangles, degrees; the minimum is a wish

  // Options of Poisson.
  std::uint32_t depth = 0;   // of the octree, 2^depth cells along a side; 0: by the spacing, 6-10
  double samplesPerNode = 1; // a larger number suits noisy points
  double pointWeight = 4;    // how closely the surface follows the points
  // Drops triangles that are farther than this number of spacings from all points; 0: keeps all.
  double trimDistance = 0;
};

struct Reconstruction
{
  std::vector<Triangle> triangles; // counter-clockwise seen from outside
  // Poisson: the surface's points. Greedy: empty, because triangles use the input's points.
  std::vector<Vec3> points;
  std::vector<VertexId> nearest; // Poisson: the nearest input point of each of `points`
  std::vector<Vec3> normals;     // of the triangles' points, unit length
  double spacing = 0; // median distance to the sixth nearest point, or the farthest of fewer
};

// Steps reported: "neighbors", "normals", "surface". normals: none, or one for each point; normals
// that are zero or not finite are estimated. PCL works with floats relative to the box's centre.
// Points that are in the same place after this rounding count once: the one with the lowest number
// is used, and the others are in no triangle. The result does not depend on the threads.
//
// Complexity: O(n log n) for normals and greedy; the size of the surface for Poisson. Memory: about
// 400 bytes a point, and Poisson's octree. Errors: InvalidInput for fewer than three points in
// different places, and for points that all lie on one line; LimitExceeded above 2^31 - 1 points;
// Cancelled. REQUIRES: finite points.
Result<Reconstruction> ReconstructSurface(std::span<const Vec3> points,
  std::span<const Vec3> normals, const ReconstructionOptions& options, const Execution& execution);

// Turns normals so that neighbours agree about which side of a cloud is outside
// (NormalOrientation.cxx). Starts at the known normals. If a part of the graph has no known normal,
// it starts at the part's highest point (greatest z), and turns its normal upwards. Then continues
// over the edge with the most parallel normals (Hoppe et al., Surface Reconstruction from
// Unorganized Points, 1992, section 3.3: the minimum spanning tree of 1 - |n·n'|). Ties go to the
// lowest id.
//
// points, normals, known: one for each point; normals that are `known` are not turned. neighbors: k
// ids for each point, in any order, with or without the point itself; edges go both ways. O(n k
// log(n k)); memory: about 8 n k bytes, and the queue. REQUIRES: unit normals, or zero for points
// without a normal; ids below n.
void OrientNormals(std::span<const Vec3> points, std::span<const std::uint8_t> known,
  std::span<const VertexId> neighbors, std::size_t k, std::span<Vec3> normals);

}
