// SPDX-License-Identifier: BSD-3-Clause
// Partitions of a textured store as a mesh with pictures: for kdstream-store extract.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"
#include "filters/texture/TexturedMesh.h"

#include <cstdint>
#include <span>

namespace kdstream
{

// The partitions' triangles, each once, with all arrays of vertices except colours, which the
// textures replace. Pictures are PNG bytes.
//
// Of a lossy store each partition has a material and a picture of its own, "partition-P". Of a
// lossless one the input's pictures come back, "picture-N", as large as they were: texels that a
// chart of these partitions uses (and one more around it) are the input's, multiplied by the
// material's factor; all others are grey. Corners have the input's coordinates bit for bit, and
// materials its transforms. (Tiles that had to be halved are as those of a lossy store.) Triangles
// without a picture get a material of their colour.
//
// Memory: the mesh, the PNGs, and one decoded picture. Errors: those of reading; Damaged, naming
// the blob, for an image that cannot be decoded, or whose size differs from the tile's;
// LimitExceeded for a picture of more than mostPicturePixels. REQUIRES: the model has textures;
// partitions ascend.
Result<TexturedMesh> ExtractTextured(
  const Store& store, std::span<const std::uint32_t> partitions, const Execution& execution = {});

}
