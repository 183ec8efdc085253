// SPDX-License-Identifier: BSD-3-Clause
// The seam between builders and whoever makes textures of partitions: part of step "encode" of the
// pipeline picture. Builders carry the paint of triangles (IsTexturePaint) as they carry any array,
// and hand over each piece of the original when it is cut; what a picture is they do not know.
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

  // What the model says of them, but for the counts.
  virtual TextureDescription Describe() const = 0;
  // The texture of an original's piece; takes the arrays of paint out of it. Errors: InvalidInput
  // where it has none; InputOutput; LimitExceeded.
  virtual Result<EncodedTexture> Make(Piece& piece) const = 0;
};

}
