// SPDX-License-Identifier: BSD-3-Clause
// Finds the glTF in the file of a tile. The file is glTF itself, or a b3dm ("batched 3D model", of
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
  Vec3 center{}; // RTC_CENTER: origin of the places, in the tileset's axes
};

struct TileParts
{
  std::vector<TilePart> parts;
  std::set<std::string> notRead;    // kinds of tiles in the file that are not read: "pnts"
  std::set<std::string> properties; // names in batch tables, which are not carried
};

// Reads the headers in the file. Memory: the tables. Errors: InvalidInput, continuing a sentence,
// for a header that claims more than the file has; InputOutput.
Result<TileParts> FindTileParts(const std::filesystem::path& file);

}
