// SPDX-License-Identifier: BSD-3-Clause
// Turns pieces of a textured store into a mesh with pictures: for kdstream-store extract.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"
#include "filters/texture/TexturedMesh.h"

#include <vector>

namespace kdstream
{

// The triangles of the pieces, each once, with their vertex arrays except colours, which the
// textures replace. Pictures are PNG bytes.
//
// Each piece has a material and a picture of its own, "partition-P" or "level-D-NODE". But for the
// original of a lossless store the input's pictures are restored, "picture-N", with their original
// size. Texels that a chart of these partitions uses (and one more around it) are those of the
// input, multiplied by the material's factor; all others are grey. Corners have the input's
// coordinates bit for bit, and materials the input's transforms. (Tiles that had to be halved are
// treated as those of a lossy store.) Triangles without a picture get a material of their colour.
//
// Memory: the mesh, the PNGs, and one decoded picture. Errors: those of reading; Damaged, naming
// the blob, if an image cannot be decoded or its size differs from the tile's; LimitExceeded for a
// picture of more than mostPicturePixels. REQUIRES: pieces with textures, all of one resolution,
// ascending; of a level, all its pieces.
Result<TexturedMesh> ExtractTextured(
  const Store& store, const std::vector<PieceId>& pieces, const Execution& execution = {});

}
