// SPDX-License-Identifier: BSD-3-Clause
// The interface between builders and the code that makes textures of partitions: part of step
// "encode" of the pipeline picture. Builders carry the texture coordinates of triangles
// (IsTexturePaint) as any other array, and hand over each piece of the original when it is cut.
// They know nothing of images.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

struct EncodedTexture
{
  std::vector<std::uint8_t> bytes; // TextureTile.h
  std::uint64_t texels = 0;
};

// From several threads at a time.
class PieceTextures
{
public:
  virtual ~PieceTextures() = default;

  // What the model's description says of them, except counts.
  virtual TextureDescription Describe() const = 0;
  // Makes the texture of a piece of the original; removes the arrays of texture coordinates from
  // the piece. Errors: InvalidInput if the piece has none; InputOutput; LimitExceeded.
  virtual Result<EncodedTexture> Make(Piece& piece) const = 0;
};

}
