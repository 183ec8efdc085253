// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/GltfBuffers.h"

#include "filters/meshio/QuotedText.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cstdint>
#include <fstream>
#include <string>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// What glTF calls a data URI: the bytes are in the .gltf itself.
bool IsData(const std::string& uri)
{
  return uri.rfind("data:", 0) == 0;
}

// "a b.bin" for "a%20b.bin", as which many programs write such a name.
std::string Unescaped(const std::string& uri)
{
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i)
  {
    const char* const digits = uri.data() + i + 1;
    std::uint8_t code = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2)
    {
      name += static_cast<char>(code);
      i += 2;
    }
    else
    {
      name += uri[i];
    }
  }
  return name;
}

Error NotThere(const std::string& uri, const std::filesystem::path& folder)
{
  const std::string name = Unescaped(uri);
  std::error_code failure;
  const bool escaped = name != uri && std::filesystem::is_regular_file(folder / name, failure);
  return { ErrorCode::InvalidInput,
    "the file " + QuotedText(uri) + ", in which its geometry is, is not there" +
      (escaped
          ? "; " + QuotedText(name) + " is, but the reader does not understand the %: name it " +
              "without blanks or signs"
          : "") };
}

Status CheckBuffer(const Json& buffer, const std::filesystem::path& folder)
{
  const auto uri = buffer.is_object() ? buffer.find("uri") : buffer.end();
  if (!buffer.is_object() || uri == buffer.end() || !uri->is_string())
  {
    return {};
  }
  const std::string& name = uri->get_ref<const std::string&>();
  if (IsData(name))
  {
    return {};
  }
  std::error_code failure;
  const std::filesystem::path file = folder / name;
  const bool there = std::filesystem::is_regular_file(file, failure);
  const std::uintmax_t bytes = there ? std::filesystem::file_size(file, failure) : 0;
  if (!there || failure)
  {
    return NotThere(name, folder);
  }
  const auto length = buffer.find("byteLength");
  if (length != buffer.end() && length->is_number_unsigned() &&
      length->get<std::uint64_t>() > bytes)
  {
    return Error{ ErrorCode::InvalidInput,
      "claims " + std::to_string(length->get<std::uint64_t>()) + " bytes of the file " +
        QuotedText(name) + "; it has " + std::to_string(bytes) };
  }
  return {};
}

}

Status CheckGltfBuffers(const std::filesystem::path& file)
{
  std::ifstream text(file, std::ios::binary);
  if (!text)
  {
    return Error{ ErrorCode::InputOutput, "cannot be opened" };
  }
  const Json scene = Json::parse(text, nullptr, false);
  const auto buffers = scene.is_object() ? scene.find("buffers") : scene.end();
  if (!scene.is_object() || buffers == scene.end() || !buffers->is_array())
  {
    return {};
  }
  for (const Json& buffer : *buffers)
  {
    KDSTREAM_TRY(CheckBuffer(buffer, file.parent_path()));
  }
  return {};
}

}
