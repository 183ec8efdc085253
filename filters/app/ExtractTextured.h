// SPDX-License-Identifier: BSD-3-Clause
// Pieces of a textured store as a mesh with pictures: for kdstream-store extract.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"
#include "filters/texture/TexturedMesh.h"

#include <vector>

namespace kdstream
{

// The pieces' triangles, each once, with their arrays of vertices except colours, which the
// textures replace. Pictures are PNG bytes.
//
// Each piece has a material and a picture of its own, "partition-P" or "level-D-NODE". But of the
// original of a lossless store the input's pictures come back, "picture-N", as large as they were:
// texels that a chart of these partitions uses (and one more around it) are the input's, multiplied
// by the material's factor; all others are grey. Corners have the input's coordinates bit for bit,
// and materials its transforms. (Tiles that had to be halved are as those of a lossy store.)
// Triangles without a picture get a material of their colour.
//
// Memory: the mesh, the PNGs, and one decoded picture. Errors: those of reading; Damaged, naming
// the blob, for an image that cannot be decoded, or whose size differs from the tile's;
// LimitExceeded for a picture of more than mostPicturePixels. REQUIRES: pieces with textures, of
// one resolution, all of a level; they ascend.
Result<TexturedMesh> ExtractTextured(
  const Store& store, const std::vector<PieceId>& pieces, const Execution& execution = {});

}
