// SPDX-License-Identifier: BSD-3-Clause
// The interface between builders and the code that makes textures: part of step "encode" of the
// pipeline picture. Builders know nothing of images. They carry the texture coordinates of
// triangles (IsTextureArray) like any other array. First each piece of the original is passed when
// it is cut; later each piece of a level, with the finer pieces around it.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace kdstream
{

struct EncodedTexture
{
  std::vector<std::uint8_t> bytes; // TextureTile.h
  std::uint64_t texels = 0;
};

struct FinerPiece
{
  Piece piece;
  std::vector<std::uint8_t> texture; // TextureTile.h
};

// Pieces of the next finer resolution around a piece.
struct FinerPieces
{
  struct Place
  {
    PieceId id;
    Box box;           // of the piece's own vertices
    bool below = true; // true: the tile covers part of the piece; false: it is beside the piece
  };
  std::vector<Place> places;
  // Reads the piece at a place and its texture. May be called any number of times.
  std::function<Result<FinerPiece>(std::size_t)> read;
  // Called often while a texture is made; returns false to stop. Null: never.
  std::function<bool()> goesOn = nullptr;
};

// Its functions may be called by several threads at the same time.
class PieceTextures
{
public:
  virtual ~PieceTextures() = default;

  // The textures' entry in the model's description, without counts. `levels`: whether MakeOfLevel
  // is implemented. If the model has no levels, MakeOfLevel is not called.
  virtual TextureDescription Describe() const = 0;
  // Makes the texture of a piece of the original; removes the arrays of texture coordinates from
  // the piece. Errors: InvalidInput if the piece has none; InputOutput; LimitExceeded.
  virtual Result<EncodedTexture> Make(Piece& piece) const = 0;
  // Makes the texture of a piece of a level. REQUIRES: Describe().levels. Errors: those of
  // finer.read; Damaged; LimitExceeded; Cancelled.
  virtual Result<EncodedTexture> MakeOfLevel(
    const Piece& /*piece*/, const FinerPieces& /*finer*/) const
  {
    return EncodedTexture{};
  }
};

}
