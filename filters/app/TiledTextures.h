// SPDX-License-Identifier: BSD-3-Clause
// Makes textures of partitions from what kdstream-convert has left: part of step "encode" of the
// pipeline picture.
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

// The finer pieces that were read last: those beside each other read the same ones. Any number of
// threads.
class FinerCache
{
public:
  // Null: it is not here.
  std::shared_ptr<const FinerColors> Find(PieceId id);
  void Keep(PieceId id, std::shared_ptr<const FinerColors> finer);

private:
  static constexpr std::size_t mostBytes = std::size_t{ 32 } << 20;

  std::mutex Mutex;
  std::vector<std::pair<PieceId, std::shared_ptr<const FinerColors>>> Kept; // the latest one last
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

  // The counts of the original's tiles that were made so far.
  TileCounts Counts() const;
  // What the user should know of them, a sentence each.
  std::vector<std::string> Warnings() const;

private:
  const std::shared_ptr<const TextureFolder> Folder;
  const TileOptions Options;
  mutable std::mutex LargeTile; // TileOptions::oneLarge
  mutable FinerCache Finer;
  mutable std::mutex Mutex; // of the sums
  mutable TileCounts Sums;
};

}
