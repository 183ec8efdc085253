// SPDX-License-Identifier: BSD-3-Clause
// The JSON of a glTF file, and what is looked up in it, where nothing is taken on trust.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/Tolerance.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// Where a glTF lies in its file: all of it, or a part, as tiles of 3D Tiles hold one.
struct GltfRange
{
  std::uint64_t begin = 0;
  std::optional<std::uint64_t> bytes{}; // none: to the end
};

struct GltfDocument
{
  nlohmann::json json;           // an object
  std::uint64_t binary = 0;      // where in the file the chunk of bytes (BIN) of a .glb begins
  std::uint64_t binaryBytes = 0; // length of the binary chunk, 0 if there is none
  std::string otherChunk;        // the second chunk's name, if it is not the binary chunk
  bool isGlb = false;            // by its first bytes, whatever the file is called
  Tolerance tolerance{};         // bytes after the end of a .glb, chunks before that of bytes
};

// Peak memory: several times the JSON. Errors: InvalidInput for a file that is not glTF 2, that is
// shorter than it claims, or whose JSON is truncated or malformed (naming the byte).
Result<GltfDocument> ReadGltfDocument(
  const std::filesystem::path& file, const GltfRange& range = {});

// A member, or null: also where the value is not an object.
const nlohmann::json& Member(const nlohmann::json& value, const char* name);
// A finite number.
double NumberOf(const nlohmann::json& value, double otherwise);
// A whole number from 0 to 2^53, which JSON has exactly; -1 for anything else.
double WholeOf(const nlohmann::json& value, double otherwise);
// The size of an array; 0 for anything else.
std::size_t CountOf(const nlohmann::json& array);
// The number of an element of an array, 2 or 2.0; the array's size for anything else.
std::size_t IndexIn(const nlohmann::json& array, const nlohmann::json& index);
// The content of a data URI: base64 (RFC 4648, also URL-safe and with line ends), or characters,
// some of them written as %HH. Nothing if it is neither.
std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri);
// "names image 7, but there are 2".
std::string NamesNone(
  const std::string& element, const nlohmann::json& index, const nlohmann::json& array);
// An error of InvalidInput.
inline Error GltfError(const std::string& message, Remedy remedy = Remedy::Unknown)
{
  return BadInput(message, remedy);
}
// The error with `where` before what is wrong.
Error Within(const std::string& where, Error error);

// Checks that every extension that the file requires is supported, or concerns only how it looks.
// `notRead` gets a sentence naming the used extensions that are not supported. Errors: Unsupported,
// naming the extension.
Status CheckGltfExtensions(const nlohmann::json& json, std::optional<std::string>& notRead);

}
