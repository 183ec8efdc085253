// SPDX-License-Identifier: BSD-3-Clause
// Decompresses the geometry of glTF files, by meshoptimizer or Draco. Both libraries are optional.
#pragma once

#include "filters/convert/gltf/GltfAccessors.h"
#include "filters/core/Result.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// The JSON that says how a bufferView is compressed (EXT_meshopt_compression,
// KHR_meshopt_compression), or null.
const nlohmann::json& MeshoptOf(const nlohmann::json& view);

// Decompresses the view. Claims are compared with `bytes` before memory is allocated. Errors:
// InvalidInput, continuing the sentence "bufferView 7 …"; Unsupported if built without
// libmeshoptimizer-dev.
Result<std::vector<std::uint8_t>> DecodeMeshopt(
  const nlohmann::json& compressed, std::span<const std::uint8_t> bytes);

struct DracoPart
{
  std::vector<std::uint32_t> corners;             // three for each triangle
  std::map<std::string, GltfAccessor> attributes; // the requested ones
};

// Decompresses a mesh part compressed by KHR_draco_mesh_compression. attributes: names, with their
// numbers in the compressed part. normalized: the attributes whose whole numbers are divided by the
// largest of their type. Memory: what the library takes, several times the part. Errors:
// InvalidInput, continuing the sentence "… part 0: …"; Unsupported if built without libdraco-dev.
Result<DracoPart> DecodeDraco(std::span<const std::uint8_t> bytes,
  const std::map<std::string, std::uint32_t>& attributes, const std::set<std::string>& normalized);

}
