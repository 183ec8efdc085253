// SPDX-License-Identifier: BSD-3-Clause
// The parts of a scene as one mesh.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/texture/TexturedMesh.h"

#include <span>
#include <vector>

namespace kdstream
{

// One mesh after the other. An attribute stays if all parts that have points have it with one type;
// where only some have colours, the others become white. What is dropped becomes a warning.
// Errors: LimitExceeded.
Result<ForeignMesh> JoinParts(std::span<ForeignMesh> parts);

// Colours of the mesh's points, each channel from 0 to 1, in sRGB; with alpha only if one is below
// 1.
void AddColors(Mesh& mesh, const std::vector<Color>& colors);

}
