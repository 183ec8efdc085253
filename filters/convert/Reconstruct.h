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

// As vtkPCLSurfaceReconstruction with its defaults; attributes travel as it says. Steps reported:
// "surface". Errors: InvalidInput for a mesh that has triangles, and that filter's; Unsupported
// without PCL; Cancelled.
Result<ForeignMesh> ReconstructMesh(
  ForeignMesh cloud, Reconstruct method, const Execution& execution);

}
