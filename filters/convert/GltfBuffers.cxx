#include "filters/convert/GltfBuffers.h"

#include "filters/meshio/QuotedText.h"

#include <nlohmann/json.hpp>

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
    return Error{ ErrorCode::InvalidInput,
      "the file " + QuotedText(name) + ", in which its geometry is, is not there" };
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
    if (Status status = CheckBuffer(buffer, file.parent_path()); !status)
    {
      return status;
    }
  }
  return {};
}

}
