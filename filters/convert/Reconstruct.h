// SPDX-License-Identifier: BSD-3-Clause
// A surface of a point cloud, before it is written: kdstream-convert --reconstruct.
#pragma once

#include "filters/convert/ForeignMesh.h"

namespace kdstream
{

enum class Reconstruct
{
  Greedy,
  Poisson
};

// As vtkPCLSurfaceReconstruction with its defaults, also for attributes. Steps reported: "surface".
// Errors: InvalidInput for a mesh that has triangles; those of that filter; Unsupported without
// PCL; Cancelled.
Result<ForeignMesh> ReconstructMesh(
  ForeignMesh cloud, Reconstruct method, const Execution& execution);

}
