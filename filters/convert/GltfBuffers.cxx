// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/GltfBuffers.h"

#include "filters/convert/GltfDocument.h"
#include "filters/core/TakeResult.h"
#include "filters/core/Texts.h"
#include "filters/meshio/QuotedText.h"

#include <cstdint>
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

// How many bytes the file has, which must be there.
Result<std::uint64_t> BytesOfFile(const std::string& name, const std::filesystem::path& folder)
{
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
  return there && !failure ? Result<std::uint64_t>(bytes) : NotThere(name, folder);
}

Status CheckBuffer(
  const GltfDocument& document, std::size_t number, const std::filesystem::path& folder)
{
  const Json& buffer = Member(document.json, "buffers")[number];
  const Json& uri = Member(buffer, "uri");
  const std::string name = uri.is_string() ? uri.get<std::string>() : std::string();
  std::uint64_t bytes = 0;
  std::string place;
  if (IsData(name))
  {
    const auto data = DataOf(name);
    if (!data)
    {
      return Error{ ErrorCode::InvalidInput,
        "buffer " + std::to_string(number) + " is a data URI that is no base64" };
    }
    bytes = data->size();
    place = "buffer " + std::to_string(number);
  }
  else if (uri.is_string())
  {
    KDSTREAM_TRY(Take(BytesOfFile(name, folder), bytes));
    place = "the file " + QuotedText(name);
  }
  else if (document.isGlb && number == 0)
  {
    bytes = document.binaryBytes;
    place = "its second chunk";
  }
  else
  {
    return {}; // that none of these is there tells who uses it
  }
  const double length = NumberOf(Member(buffer, "byteLength"), 0);
  return length <= double(bytes)
           ? Status{}
           : Status(Error{ ErrorCode::InvalidInput,
               "claims " + Member(buffer, "byteLength").dump() + " bytes of " + place +
                 "; it has " + std::to_string(bytes) });
}

}

Status CheckGltfBuffers(const GltfDocument& document, const std::filesystem::path& folder)
{
  for (std::size_t i = 0; i < CountOf(Member(document.json, "buffers")); ++i)
  {
    KDSTREAM_TRY(CheckBuffer(document, i, folder));
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
