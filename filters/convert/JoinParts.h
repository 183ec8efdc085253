// SPDX-License-Identifier: BSD-3-Clause
// The parts of a scene as one mesh.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/texture/TexturedMesh.h"

#include <span>
#include <vector>

namespace kdstream
{

// Joins meshes, one after the other. An attribute stays if all parts with points have it with the
// same type; if only some parts have colours, the others become white. A warning lists what is
// dropped. Errors: LimitExceeded.
Result<ForeignMesh> JoinParts(std::span<ForeignMesh> parts);

// Colours of the mesh's points, each channel from 0 to 1, in sRGB; with alpha only if one is below
// 1.
void AddColors(Mesh& mesh, const std::vector<Color>& colors);

}
