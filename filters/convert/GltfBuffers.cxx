// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/GltfBuffers.h"

#include "filters/convert/GltfDocument.h"
#include "filters/core/Texts.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

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

Error NotThere(const std::string& uri, const std::filesystem::path& folder)
{
  const std::string name = PercentDecoded(uri).value_or(uri);
  std::error_code failure;
  const bool escaped = name != uri && std::filesystem::is_regular_file(folder / name, failure);
  return { ErrorCode::InvalidInput,
    "the file " + QuotedText(uri) + ", in which its geometry is, is not there" +
      (escaped
          ? "; " + QuotedText(name) + " is, but the reader does not understand the %: name it " +
              "without blanks or signs"
          : "") };
}

// Whether it may be read: nothing outside the folder is, but through links that lie in it.
bool LiesBelow(const std::string& name)
{
  const std::filesystem::path place = std::filesystem::path(name).lexically_normal();
  return place.empty() || (!place.is_absolute() && *place.begin() != "..");
}

// Bytes of an accessor's element; 0 where its kind is unknown.
double ElementBytes(const Json& accessor)
{
  static constexpr std::array<std::pair<const char*, double>, 7> types{ { { "SCALAR", 1 },
    { "VEC2", 2 }, { "VEC3", 3 }, { "VEC4", 4 }, { "MAT2", 4 }, { "MAT3", 9 }, { "MAT4", 16 } } };
  static constexpr std::array<double, 7> bytes{ 1, 1, 2, 2, 0, 4, 4 }; // of 5120 …
  const auto type = std::find_if(types.begin(), types.end(),
    [&](const auto& known) { return Member(accessor, "type") == known.first; });
  const double kind = NumberOf(Member(accessor, "componentType"), 0) - 5120;
  const bool known = type != types.end() && kind >= 0 && kind < double(bytes.size());
  return known ? type->second * bytes[static_cast<std::size_t>(kind)] : 0;
}

// Numbers are those of JSON: whole ones are exact up to 2^53.
Status CheckAccessor(const Json& json, const Json& accessor)
{
  const Json& views = Member(json, "bufferViews");
  const Json& number = Member(accessor, "bufferView");
  const std::size_t at = IndexIn(views, number);
  if (number.is_null())
  {
    return {}; // zeros
  }
  if (at == CountOf(views))
  {
    return Error{ ErrorCode::InvalidInput, NamesNone("bufferView", number, views) };
  }
  const Json& view = views[at];
  const double length = NumberOf(Member(view, "byteLength"), 0);
  const double count = NumberOf(Member(accessor, "count"), -1), size = ElementBytes(accessor);
  const double stride = NumberOf(Member(view, "byteStride"), size);
  const double room = length - NumberOf(Member(accessor, "byteOffset"), 0) - size;
  if (count < 0 || (count > 0 && size > 0 && (room < 0 || (count - 1) * stride > room)))
  {
    return Error{ ErrorCode::InvalidInput,
      "claims " + Member(accessor, "count").dump() + " elements, more than its bufferView has" };
  }
  const Json& buffers = Member(json, "buffers");
  const std::size_t buffer = IndexIn(buffers, Member(view, "buffer"));
  const double all =
    buffer < CountOf(buffers) ? NumberOf(Member(buffers[buffer], "byteLength"), 0) : 0;
  return NumberOf(Member(view, "byteOffset"), 0) + length <= all
           ? Status{}
           : Status(Error{
               ErrorCode::InvalidInput, "lies in a bufferView that reaches beyond its buffer" });
}

Status CheckBuffer(const Json& buffer, const std::filesystem::path& folder)
{
  const Json& uri = Member(buffer, "uri");
  if (!uri.is_string())
  {
    return {};
  }
  const std::string& name = uri.get_ref<const std::string&>();
  if (IsData(name))
  {
    return {};
  }
  if (!LiesBelow(name))
  {
    return Error{ ErrorCode::InvalidInput,
      "the file " + QuotedText(name) +
        ", in which its geometry is, lies outside its folder, where nothing is read" };
  }
  std::error_code failure;
  const std::filesystem::path file = folder / name;
  const bool there = std::filesystem::is_regular_file(file, failure);
  const std::uintmax_t bytes = there ? std::filesystem::file_size(file, failure) : 0;
  if (!there || failure)
  {
    return NotThere(name, folder);
  }
  const Json& length = Member(buffer, "byteLength");
  if (length.is_number_unsigned() && length.get<std::uint64_t>() > bytes)
  {
    return Error{ ErrorCode::InvalidInput, "claims " + std::to_string(length.get<std::uint64_t>()) +
                                             " bytes of the file " + QuotedText(name) +
                                             "; it has " + std::to_string(bytes) };
  }
  return {};
}

}

Status CheckGltfBuffers(const Json& json, const std::filesystem::path& folder)
{
  const Json& buffers = Member(json, "buffers");
  for (std::size_t i = 0; i < CountOf(buffers); ++i)
  {
    KDSTREAM_TRY(CheckBuffer(buffers[i], folder));
  }
  return {};
}

Status CheckGltfAccessors(const Json& json)
{
  const Json& accessors = Member(json, "accessors");
  for (std::size_t i = 0; i < CountOf(accessors); ++i)
  {
    if (const Status checked = CheckAccessor(json, accessors[i]); !checked)
    {
      return Error{ ErrorCode::InvalidInput,
        "accessor " + std::to_string(i) + " " + checked.GetError().message };
    }
  }
  return {};
}

std::vector<std::filesystem::path> GltfBufferFiles(
  const Json& json, const std::filesystem::path& folder)
{
  const Json& buffers = Member(json, "buffers");
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < CountOf(buffers); ++i)
  {
    const Json& uri = Member(buffers[i], "uri");
    if (uri.is_string() && !IsData(uri.get_ref<const std::string&>()))
    {
      files.push_back(folder / uri.get_ref<const std::string&>());
    }
  }
  return files;
}

}
