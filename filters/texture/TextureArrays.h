// SPDX-License-Identifier: BSD-3-Clause
// Texture coordinates and materials of triangles as arrays that travel with a mesh through the
// build (IsTextureArray), and back. Between steps "read" and "encode" of the pipeline picture.
#pragma once

#include "filters/core/pieces/Piece.h"
#include "filters/texture/TileCharts.h"

#include <cstddef>
#include <optional>

namespace kdstream
{

// Adds the arrays to textured.mesh, replacing arrays with the same names.
void AddTextureArrays(TexturedMesh& textured);

// Removes the arrays from a piece. Returns nothing if it does not have both, or if one of them
// names a material that does not exist. The result refers to the piece's triangles.
std::optional<TexturedTriangles> TakeTextureArrays(Piece& piece, std::size_t materials);

}
