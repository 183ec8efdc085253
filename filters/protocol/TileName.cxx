// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/TileName.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/TextParts.h"

namespace kdstream::protocol
{

namespace
{
constexpr std::string_view rootTilesetName = "tileset.json";
constexpr std::string_view originalTiles = "original";
}

std::string NameOfTile(const TileName& tile)
{
  if (tile.isRoot)
  {
    return std::string(rootTilesetName);
  }
  return (tile.isOriginal ? std::string(originalTiles) : std::to_string(tile.level)) + "/" +
         std::to_string(tile.number) + (tile.isTileset ? ".json" : ".glb");
}

Result<TileName> ParseTileName(std::string_view name)
{
  TileName tile;
  if (name == rootTilesetName)
  {
    tile.isRoot = tile.isTileset = true;
    return tile;
  }
  const auto parts = SplitPath(name);
  const bool isTileset = name.ends_with(".json");
  if (parts.size() != 2 || (!isTileset && !name.ends_with(".glb")))
  {
    return Error{ ErrorCode::NotFound, "there is no tile named " + Quoted(name) };
  }
  tile.isTileset = isTileset;
  tile.isOriginal = parts[0] == originalTiles;
  if (!tile.isOriginal)
  {
    const auto level = ParseDecimal(parts[0], 0, maximumDepth);
    if (!level)
    {
      return Error{ ErrorCode::InvalidArgument, "no level " + Quoted(parts[0]) };
    }
    tile.level = static_cast<std::uint8_t>(*level);
  }
  const auto digits = parts[1].substr(0, parts[1].rfind('.'));
  const auto number = ParseDecimal(digits, 0, (1U << maximumDepth) - 1);
  if (!number)
  {
    return Error{ ErrorCode::InvalidArgument, "no tile " + Quoted(digits) };
  }
  tile.number = *number;
  return tile;
}

}
