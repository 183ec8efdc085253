// SPDX-License-Identifier: BSD-3-Clause
// The file of a tile: where in it glTF lies. It is glTF itself, or a b3dm ("batched 3D model", of
// 3D Tiles 1.0) around it, or a cmpt ("composite") of several tiles.
#pragma once

#include "filters/convert/gltf/GltfDocument.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace kdstream
{

struct TilePart
{
  GltfRange range;
  Vec3 center{}; // RTC_CENTER: what the places are counted from, in the tileset's axes
};

struct TileParts
{
  std::vector<TilePart> parts;
  std::set<std::string> notRead;    // kinds of tiles in it that are not read: "pnts"
  std::set<std::string> properties; // of batch tables, which are not carried
};

// Reads the heads of the file. Memory: the tables. Errors: InvalidInput, continuing a sentence, for
// a head that claims more than the file has; InputOutput.
Result<TileParts> FindTileParts(const std::filesystem::path& file);

}
