// SPDX-License-Identifier: BSD-3-Clause
// Makes textures of partitions from the files that kdstream-convert has left: part of step "encode"
// of the pipeline picture.
#pragma once

#include "filters/build/PieceTextures.h"
#include "filters/texture/MakeTile.h"
#include "filters/texture/TextureFolder.h"
#include "filters/texture/levels/FinerColors.h"

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// The finer pieces that were read last; adjacent pieces need the same ones. Any number of threads
// may use it.
class FinerCache
{
public:
  // Null if the piece is not in the cache.
  std::shared_ptr<const FinerColors> Find(PieceId id);
  void Keep(PieceId id, std::shared_ptr<const FinerColors> finer);

private:
  static constexpr std::size_t mostBytes = std::size_t{ 32 } << 20;

  std::mutex Mutex;
  // The most recently used one is last.
  std::vector<std::pair<PieceId, std::shared_ptr<const FinerColors>>> Kept;
  std::size_t Bytes = 0;
};

class TiledTextures : public PieceTextures
{
public:
  TiledTextures(std::shared_ptr<const TextureFolder> textures, const TileOptions& options)
    : Folder(std::move(textures))
    , Options(options)
  {
  }

  TextureDescription Describe() const override;
  Result<EncodedTexture> Make(Piece& piece) const override;
  Result<EncodedTexture> MakeOfLevel(const Piece& piece, const FinerPieces& finer) const override;

  // The counts of the tiles made so far for the original.
  TileCounts Counts() const;
  // Warnings about these tiles, one sentence each.
  std::vector<std::string> Warnings() const;

private:
  const std::shared_ptr<const TextureFolder> Folder;
  const TileOptions Options;
  mutable std::mutex LargeTile; // TileOptions::oneLarge
  mutable FinerCache Finer;
  mutable std::mutex Mutex; // for Sums
  mutable TileCounts Sums;
};

}
