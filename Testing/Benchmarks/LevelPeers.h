// SPDX-License-Identifier: BSD-3-Clause
// Meshes that other libraries make at a given number of triangles: the peers of BenchLevels.
#pragma once

#include "filters/core/Types.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <string>
#include <vector>

namespace kdstream::bench
{

struct PeerMesh
{
  std::string method;
  Mesh mesh;
  double seconds = 0; // of the simplification only
};

// Simplifies one mesh with the peers.
class LevelPeers
{
public:
  explicit LevelPeers(const Mesh& mesh);

  // Simplifies to `triangles`, or as near as the method gets: vtkQuadricDecimation, vtkDecimatePro
  // (PreserveTopology off), meshopt_simplify if it was found.
  std::vector<PeerMesh> ByTarget(std::size_t triangles) const;
  // Simplifies by a grid of n³ bins, n the smallest that gives at least this number of triangles:
  // vtkQuadricClustering, vtkBinnedDecimation (its best mode, bin averages).
  std::vector<PeerMesh> ByGrid(std::size_t triangles) const;

private:
  const Mesh& Input;
  vtkSmartPointer<vtkPolyData> Data;
};

}
