// Normals of a cloud that came without. Step "draw" of the README's picture.
#pragma once

#include "filters/core/Surface.h"

#include <array>
#include <vector>

namespace kdstream
{

// The unit normal of the plane through every point and its 12 nearest neighbours, in the sense of
// least squares; either side may be its front. (0, 0, 0) where these lie on a line or on top of
// each other, or are fewer than 3.
//
// Neighbours are looked for among the 64 points of a run alone (SplatRadii.h), so at the edge of a
// run they lie to one side: enough to light a splat. O(points). REQUIRES: finite coordinates.
// Source: H. Hoppe et al., Surface Reconstruction from Unorganized Points, SIGGRAPH 1992, section
// 3.2.
std::vector<std::array<float, 3>> EstimateNormals(const Surface& cloud);

}
