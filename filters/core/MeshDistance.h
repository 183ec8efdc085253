// SPDX-License-Identifier: BSD-3-Clause
// Measures by samples how far two meshes are from each other: how levels are judged. Not in the web
// build.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>

namespace kdstream
{

struct MeshDistanceOptions
{
  std::size_t samples = 100000; // on each of the two meshes, at least 1
  std::uint64_t seed = 1;
};

// All in model units.
struct MeshDistance
{
  double rmsForward = 0;  // from samples of the reference to the other mesh
  double rmsBackward = 0; // from samples of the other mesh to the reference
  double hausdorff = 0;   // the largest distance of any sample, both ways
  double diagonal = 0;    // of the reference's box: distances are usually divided by it
};

// Measures the distance of `other` from `reference`.
//
// Samples are uniform over the area of a mesh's triangles, or over its vertices if it has no
// triangle with an area. For each sample finds the exact closest point of the other mesh: on its
// triangles (degenerate ones are segments or points), or its vertices if it has no triangles. The
// results do not depend on the number of threads. Because of the sampling a Hausdorff distance is a
// lower bound. Complexity: O(t log t + samples log t) on average; memory about 100 bytes a
// triangle. Errors: InvalidArgument for a mesh without vertices, a coordinate that is not finite, a
// triangle with an index out of range, or 0 samples; Cancelled (step "distance").
Result<MeshDistance> MeasureDistance(const Mesh& reference, const Mesh& other,
  const MeshDistanceOptions& options = {}, const Execution& execution = {});

}
