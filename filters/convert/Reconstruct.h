// SPDX-License-Identifier: BSD-3-Clause
// Reconstructs the surface of a point cloud before it is written: kdstream-convert --reconstruct.
#pragma once

#include "filters/convert/ForeignMesh.h"

namespace kdstream
{

enum class Reconstruct
{
  Greedy,
  Poisson
};

// Works as vtkPCLSurfaceReconstruction does with its defaults, also for attributes. Reports the
// step "surface". Errors: InvalidInput for a mesh that has triangles; those of that filter;
// Unsupported without PCL; Cancelled.
Result<ForeignMesh> ReconstructMesh(
  ForeignMesh cloud, Reconstruct method, const Execution& execution);

}
