// SPDX-License-Identifier: BSD-3-Clause
// The JSON of a glTF file, and functions that look up values in it without trusting the file.
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

// Where a glTF lies in its file: it is the whole file, or a part, as in tiles of 3D Tiles.
struct GltfRange
{
  std::uint64_t begin = 0;
  std::optional<std::uint64_t> bytes{}; // nothing: up to the end
};

struct GltfDocument
{
  nlohmann::json json;           // an object
  std::uint64_t binary = 0;      // where in the file the binary chunk (BIN) of a .glb begins
  std::uint64_t binaryBytes = 0; // length of the binary chunk, 0 if there is none
  std::string otherChunk;        // the second chunk's name, if it is not the binary chunk
  bool isGlb = false;            // by its first bytes, whatever its name is
  Tolerance tolerance{};         // bytes after a .glb's end, chunks before the binary one
};

// Peak memory: several times the JSON. Errors: InvalidInput for a file that is not glTF 2, that is
// shorter than it claims, or whose JSON is truncated or malformed (naming the byte).
Result<GltfDocument> ReadGltfDocument(
  const std::filesystem::path& file, const GltfRange& range = {});

// The member of this name, or null; also null if the value is not an object.
const nlohmann::json& Member(const nlohmann::json& value, const char* name);
// The value, if it is a finite number; else `otherwise`.
double NumberOf(const nlohmann::json& value, double otherwise);
// The value, if it is a whole number from 0 to 2^53, which JSON holds exactly; `otherwise` for
// null; -1 for anything else.
double WholeOf(const nlohmann::json& value, double otherwise);
// The size of an array; 0 for anything else.
std::size_t CountOf(const nlohmann::json& array);
// The index of an element of an array, which may be written as 2 or 2.0; the array's size for
// anything else.
std::size_t IndexIn(const nlohmann::json& array, const nlohmann::json& index);
// The content of a data URI: base64 (RFC 4648, also URL-safe and with line breaks), or characters,
// some of them written as %HH. Nothing if it is neither.
std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri);
// A message: "names image 7, but there are 2".
std::string NamesNone(
  const std::string& element, const nlohmann::json& index, const nlohmann::json& array);
// An error of InvalidInput.
inline Error GltfError(const std::string& message, Remedy remedy = Remedy::Unknown)
{
  return BadInput(message, remedy);
}
// The error, with `where` in front of its message.
Error Within(const std::string& where, Error error);

// Checks that every extension that the file requires is supported, or concerns only how the scene
// looks. `notRead` gets a sentence with the used extensions that are not supported. Errors:
// Unsupported, naming the extension.
Status CheckGltfExtensions(const nlohmann::json& json, std::optional<std::string>& notRead);

}
