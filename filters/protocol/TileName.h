// SPDX-License-Identifier: BSD-3-Clause
// Names a file of a model's tileset: "tileset.json", "11/0.glb", "original/12.glb", "15/3.json"
// (the tileset below a tile), or "original/131.json" (the tileset of the partitions below node
// 131). kdstream-store export --format 3dtiles gives its files these names.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream::protocol
{

struct TileName
{
  bool isTileset = false;  // a .json, not a .glb
  bool isRoot = false;     // tileset.json; the other members are then unused
  bool isOriginal = false; // otherwise of a level
  std::uint8_t level = 0;
  std::uint32_t number =
    0; // piece number in its resolution, from 0; for a group's tileset the node
  bool operator==(const TileName&) const = default;
};

std::string NameOfTile(const TileName& tile);

// The inverse, as strict as ParseBlobName. Errors: NotFound if the name has none of these forms;
// InvalidArgument naming the wrong number.
Result<TileName> ParseTileName(std::string_view name);

}
