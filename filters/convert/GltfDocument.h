// SPDX-License-Identifier: BSD-3-Clause
// The JSON of a glTF file, and what is looked up in it, where nothing is taken on trust.
#pragma once

#include "filters/core/Result.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

struct GltfDocument
{
  nlohmann::json json;           // an object
  std::uint64_t binary = 0;      // where the bytes of a .glb's second chunk begin
  std::uint64_t binaryBytes = 0; // that it has, 0 where there is none
  bool isGlb = false;
};

// Nothing where there is no JSON of an object. Peak memory: some times the JSON.
std::optional<GltfDocument> ReadGltfDocument(const std::filesystem::path& file);

// A member, or null: also where the value is no object.
const nlohmann::json& Member(const nlohmann::json& value, const char* name);
// A finite number.
double NumberOf(const nlohmann::json& value, double otherwise);
// Of an array; 0 of everything else.
std::size_t CountOf(const nlohmann::json& array);
// The number of an element of an array; its size where it is none.
std::size_t IndexIn(const nlohmann::json& array, const nlohmann::json& index);
// What is in a data URI; nothing where that is not in base64.
std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri);
// "names image 7, but there are 2".
std::string NamesNone(
  const std::string& element, const nlohmann::json& index, const nlohmann::json& array);

// Whether geometry is as it is written. Errors: InvalidInput naming the extension that compresses
// it.
Status CheckGltfExtensions(const nlohmann::json& json);

// Whether nodes are trees, or nearly: a reader follows each way down to a node. Errors:
// InvalidInput for a node that is its own descendant, or that has, by nodes that several share,
// far more descendants than there are nodes.
Status CheckGltfNodes(const nlohmann::json& json);

}
