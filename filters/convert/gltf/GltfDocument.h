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

struct GltfDocument
{
  nlohmann::json json;           // an object
  std::uint64_t binary = 0;      // where the bytes of a .glb's second chunk begin
  std::uint64_t binaryBytes = 0; // that it has, 0 where there is none
  bool isGlb = false;            // by its first bytes, whatever the file is called
  Tolerance tolerance{};         // bytes after the end of a .glb
};

// Peak memory: some times the JSON. Errors: InvalidInput, with the byte where the JSON breaks off
// or is none, for what is no glTF, is shorter than it claims, or is of another version than 2.
Result<GltfDocument> ReadGltfDocument(const std::filesystem::path& file);

// A member, or null: also where the value is not an object.
const nlohmann::json& Member(const nlohmann::json& value, const char* name);
// A finite number.
double NumberOf(const nlohmann::json& value, double otherwise);
// A whole number from 0 to 2^53, which JSON has exactly; -1 where it is none.
double WholeOf(const nlohmann::json& value, double otherwise);
// Of an array; 0 of everything else.
std::size_t CountOf(const nlohmann::json& array);
// The number of an element of an array, 2 or 2.0; its size where it is none.
std::size_t IndexIn(const nlohmann::json& array, const nlohmann::json& index);
// What is in a data URI: in base64 (RFC 4648, with line ends or not, also as names of files have
// it), else its signs, some written as %HH. Nothing where it is neither.
std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri);
// "names image 7, but there are 2".
std::string NamesNone(
  const std::string& element, const nlohmann::json& index, const nlohmann::json& array);
// Of InvalidInput.
inline Error GltfError(const std::string& message, Remedy remedy = Remedy::Unknown)
{
  return BadInput(message, remedy);
}
// The error with `where` before what is wrong.
Error Within(const std::string& where, Error error);

// Whether every extension that the file requires is read, or concerns only looks: `notRead` gets a
// sentence that names those that the file uses and that are not read. Errors: Unsupported, naming
// the extension.
Status CheckGltfExtensions(const nlohmann::json& json, std::optional<std::string>& notRead);

}
