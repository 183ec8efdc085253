// SPDX-License-Identifier: BSD-3-Clause
// Handles pictures that consist of tiles: names with <UDIM>. Part of step "read" of the pipeline
// picture.
#pragma once

#include "filters/texture/TexturedMesh.h"

#include <string>

namespace kdstream
{

// Whether a picture's name has "<UDIM>", in any case.
bool HasTiles(const std::string& name);

// If a picture's name has "<UDIM>" (in any case), gives each of its triangles the picture of the
// tile in which the mean of the triangle's corners lies. The number of a tile is 1001 + u + 10 v,
// with u from the left and v from below, where 0 <= u < 10 and 0 <= v < 100. A triangle outside
// these tiles has no picture. Tiles are clamped at their edges. The materials must be of formats
// whose v goes up (upsideDown).
void SplitTiles(TexturedMesh& textured);

}
