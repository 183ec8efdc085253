// SPDX-License-Identifier: BSD-3-Clause
// Multiplies pictures by colours of vertices (glTF: COLOR_0), so that the tiles that are cut from
// them show both. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/texture/TextureFolder.h"
#include "filters/texture/TexturedMesh.h"

#include <span>

namespace kdstream
{

// tints: a factor for each vertex, in linear light, which triangles interpolate; clamped to 0-1.
// Changes textured.materials, .materialOf and .corners so that the tints are in the materials:
// - A triangle whose corners have one tint gets a material with it. It keeps its picture.
// - Other triangles get new pictures: the texels of their charts (FindTileCharts), each multiplied
//   by the tint at its centre. Where a chart lies on itself with different tints, its triangles
//   are copied apart. A triangle without a picture, or with too few texels for its tints, gets a
//   few of its own.
// The new pictures are added to the folder that `folder` writes, after those of `source`, which
// reads what was written so far. Vertex arrays stay as they are.
//
// Returns false, with nothing changed, if the new pictures would have more than four times as many
// texels as all pictures together, and 2^20 more: colours of vertices show such a mesh as well.
// Takes O(texels of the new pictures) time, 64 MiB for a picture, and 20 bytes for each texel of a
// chart. The result does not depend on the threads. Errors: InputOutput; Cancelled. REQUIRES: as
// many tints as vertices, in textured.mesh; existing materials.
Result<bool> TintPictures(TexturedMesh& textured, std::span<const Color> tints,
  const TextureFolder& source, TextureFolderWriter& folder, const Execution& execution = {});

}
