// SPDX-License-Identifier: BSD-3-Clause
// A subtree of implicit tiling: which of its tiles, contents and child subtrees exist.
#pragma once

#include "filters/convert/tiles/TilesetFolder.h"
#include "filters/core/Result.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// One bit for each tile, level after level, each level in Morton order.
class TileBits
{
public:
  explicit TileBits(bool all = false)
    : All(all)
  {
  }
  explicit TileBits(std::string bits)
    : Bits(std::move(bits))
  {
  }
  // REQUIRES: `tile` is in the subtree.
  bool operator[](std::size_t tile) const
  {
    return this->Bits ? (static_cast<unsigned char>((*this->Bits)[tile / 8]) >> tile % 8 & 1U) != 0
                      : this->All;
  }

private:
  bool All = false;
  std::optional<std::string> Bits;
};

struct Subtree
{
  TileBits tiles;
  std::vector<TileBits> contents; // one for each possible content of a tile
  TileBits children;              // child subtrees
};

// The size of a subtree: the number of its tiles, and of the tiles below its last level.
struct SubtreeShape
{
  std::size_t tiles = 0, children = 0;
};

// Reads a .subtree file or its JSON. file: relative to the folder. Memory: the file. Errors:
// InvalidInput, continuing a sentence: if there are not bits for all tiles.
Result<Subtree> ReadSubtree(
  const TilesetFolder& folder, const std::filesystem::path& file, const SubtreeShape& shape);

}
