// SPDX-License-Identifier: BSD-3-Clause
// Joins the parts of a scene into one mesh.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/texture/TexturedMesh.h"

#include <span>
#include <vector>

namespace kdstream
{

// Joins meshes, one after the other. An attribute stays if all parts with points have it with the
// same type. If only some parts have colours, the other parts become white. A warning lists the
// attributes that are dropped. Errors: LimitExceeded.
Result<ForeignMesh> JoinParts(std::span<ForeignMesh> parts);

// Adds colours for the mesh's points. Each channel goes from 0 to 1, in sRGB. Alpha is added only
// if one is below 1.
void AddColors(Mesh& mesh, const std::vector<Color>& colors);

}
