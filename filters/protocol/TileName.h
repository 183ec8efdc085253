// SPDX-License-Identifier: BSD-3-Clause
// Which file of a model's tileset: "tileset.json", "11/0.glb", "original/12.glb", "15/3.json", the
// tileset below a tile, and "original/131.json", that of the partitions below node 131. The names
// that kdstream-store export --format 3dtiles gives its files.
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
  bool isRoot = false;     // tileset.json; the rest says nothing then
  bool isOriginal = false; // else of a level
  std::uint8_t level = 0;
  std::uint32_t number =
    0; // among the pieces of its resolution, from 0; a node of a group's tileset
  bool operator==(const TileName&) const = default;
};

std::string NameOfTile(const TileName& tile);

// The inverse, strict as ParseBlobName. Errors: NotFound if the name has none of these forms;
// InvalidArgument naming the wrong number.
Result<TileName> ParseTileName(std::string_view name);

}
