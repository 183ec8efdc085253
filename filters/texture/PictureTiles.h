// SPDX-License-Identifier: BSD-3-Clause
// Pictures in tiles: names with <UDIM>. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/texture/TexturedMesh.h"

#include <string>

namespace kdstream
{

// Whether a picture's name has "<UDIM>", in any case.
bool HasTiles(const std::string& name);

// Gives each triangle whose picture's name has "<UDIM>" (in any case) the picture of the tile in
// which the mean of its corners lies: 1001 + u + 10 v, u from the left and v from below, where 0 <=
// u < 10 and 0 <= v < 100; outside of these it has no picture. Tiles are clamped at their edges.
// The materials must be of formats whose v goes up (upsideDown).
void SplitTiles(TexturedMesh& textured);

}
