// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/gltf/GltfDocument.h"

#include "filters/core/CaughtError.h"
#include "filters/core/Texts.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

std::uint32_t NumberAt(const char* place)
{
  std::array<unsigned char, 4> bytes{};
  std::memcpy(bytes.data(), place, bytes.size());
  return std::uint32_t{ bytes[0] } | std::uint32_t{ bytes[1] } << 8U |
         std::uint32_t{ bytes[2] } << 16U | std::uint32_t{ bytes[3] } << 24U;
}

// begin: where in the file the text begins.
Result<Json> ParseJson(const std::string& text, std::size_t begin)
{
  try
  {
    // Copying may add Ctrl-Z to the end of a text.
    const std::size_t end = text.find_last_not_of(std::string_view("\x1A\0 \t\r\n", 6));
    return Json::parse(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end + 1));
  }
  catch (const Json::parse_error& failure)
  {
    if (const std::string_view mark = std::string_view(text).substr(0, 2);
        mark == "\xFF\xFE" || mark == "\xFE\xFF")
    {
      return GltfError("its JSON is UTF-16: save it as UTF-8", Remedy::InMessage);
    }
    const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (begin == 0 && first != std::string::npos && text[first] != '{')
    {
      return GltfError(
        "is not a glTF file: it begins neither with 'glTF' nor with '{'", Remedy::Rename);
    }
    const std::size_t at = failure.byte > 0 ? failure.byte - 1 : 0;
    return at >= text.size()
             ? GltfError(
                 "its JSON breaks off at byte " + std::to_string(begin + at), Remedy::CopyAgain)
             : GltfError("its JSON is damaged at byte " + std::to_string(begin + at));
  }
  catch (const Json::exception&) // for numbers such as 1e999
  {
    return GltfError("its JSON has a number that is too large to be read");
  }
  catch (...)
  {
    return CaughtError();
  }
}

Result<std::string> ReadText(std::ifstream& file, std::uint64_t bytes)
{
  std::string text(bytes, ' ');
  if (!file.read(text.data(), static_cast<std::streamsize>(bytes)))
  {
    return Error{ ErrorCode::InputOutput, "cannot be read" };
  }
  return text;
}

// Looks for the binary chunk (BIN) among the chunks from `begin` to `end`. It should be the first
// of them, but is also found after others.
Status FindBinaryChunk(
  std::ifstream& file, std::uint64_t begin, std::uint64_t end, GltfDocument& document)
{
  constexpr std::uint64_t chunkBytes = 8;
  constexpr int mostChunks = 1000;
  std::string before;
  for (int i = 0; i < mostChunks && begin + chunkBytes <= end; ++i)
  {
    std::array<char, chunkBytes> head{};
    if (!file.seekg(static_cast<std::streamoff>(begin)) || !file.read(head.data(), head.size()))
    {
      return Error{ ErrorCode::InputOutput, "cannot be read" };
    }
    const std::uint64_t length =
      std::min<std::uint64_t>(NumberAt(head.data()), end - begin - chunkBytes);
    if (std::memcmp(head.data() + 4, "BIN", 4) == 0) // with the zero that ends it
    {
      document.binary = begin + chunkBytes;
      document.binaryBytes = length;
      if (!before.empty())
      {
        document.tolerance.Tell(
          "the chunk " + before + " before the binary chunk (BIN) is not read");
      }
      return {};
    }
    before = before.empty() ? QuotedText(std::string_view(head.data() + 4, 4)) + " (byte " +
                                std::to_string(begin) + ")"
                            : before;
    begin += chunkBytes + length;
  }
  document.otherChunk = before;
  return {};
}

// Reads a .glb: a header of twelve bytes, a chunk of JSON, and an optional binary chunk. Each chunk
// begins with its length and kind. begin: offset in the file. isPart: it lies in a tile, which may
// be padded at its end.
Result<std::string> ReadGlb(std::ifstream& file, std::uint64_t begin, std::uint64_t bytes,
  bool isPart, GltfDocument& document)
{
  constexpr std::uint64_t headBytes = 12, chunkBytes = 8;
  std::array<char, headBytes + chunkBytes> head{};
  if (bytes < head.size() || !file.read(head.data(), head.size()))
  {
    return GltfError(
      "ends inside its header: it has " + std::to_string(bytes) + " bytes", Remedy::CopyAgain);
  }
  const std::uint32_t version = NumberAt(head.data() + 4), all = NumberAt(head.data() + 8);
  const std::uint32_t length = NumberAt(head.data() + headBytes);
  if (version != 2)
  {
    return GltfError(
      "has version " + std::to_string(version) + " of glTF; only version 2 can be read",
      Remedy::SaveOtherwise);
  }
  if (all > bytes)
  {
    return GltfError("claims " + std::to_string(all) + " bytes; the file has " +
                       std::to_string(bytes) + ": it is truncated",
      Remedy::CopyAgain);
  }
  if (std::memcmp(head.data() + headBytes + 4, "JSON", 4) != 0)
  {
    return GltfError("byte 16: its first chunk must be JSON");
  }
  if (length > bytes - head.size())
  {
    return GltfError(
      "byte 12: its JSON claims " + std::to_string(length) + " bytes, more than the file has",
      Remedy::CopyAgain);
  }
  const Result<std::string> text = ReadText(file, length);
  KDSTREAM_TRY(text);
  document.isGlb = true;
  KDSTREAM_TRY(FindBinaryChunk(file, begin + head.size() + length, begin + bytes, document));
  if (!isPart && all >= head.size() + length)
  {
    document.tolerance.Count(
      Lapse::BytesAfterEnd, bytes - all, "byte " + std::to_string(all) + " of the file");
  }
  return text;
}

// Extensions that are read, and prefixes of extensions that change only the appearance.
constexpr std::array<std::string_view, 10> readExtensions{ "CESIUM_RTC", "EXT_mesh_gpu_instancing",
  "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression",
  "KHR_materials_pbrSpecularGlossiness", "KHR_mesh_quantization", "KHR_meshopt_compression",
  "KHR_node_visibility", "KHR_texture_transform" };
constexpr std::array<std::string_view, 9> looks{ "KHR_materials_", "EXT_materials_",
  "ADOBE_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_",
  "KHR_xmp" };
constexpr std::size_t mostNamed = 10;

bool IsRead(std::string_view extension)
{
  return std::find(readExtensions.begin(), readExtensions.end(), extension) != readExtensions.end();
}

// Whether the metadata holds nothing except names of arrays, which are read.
bool HasOnlyArrays(const Json& json, std::string_view extension)
{
  constexpr const char* name = "EXT_structural_metadata";
  const Json& metadata = Member(Member(json, "extensions"), name);
  return extension == name && Member(metadata, "propertyTables").is_null() &&
         Member(metadata, "propertyTextures").is_null();
}

bool ChangesLooks(std::string_view extension)
{
  return std::any_of(looks.begin(), looks.end(),
    [&](std::string_view beginning) { return extension.starts_with(beginning); });
}

}

Result<GltfDocument> ReadGltfDocument(const std::filesystem::path& file, const GltfRange& range)
{
  std::ifstream input(file, std::ios::binary);
  std::error_code failed;
  const std::uintmax_t all = std::filesystem::file_size(file, failed);
  std::array<char, 4> mark{};
  if (failed || !input)
  {
    return Error{ ErrorCode::InputOutput, "cannot be read" };
  }
  const std::uint64_t begin = std::min<std::uint64_t>(range.begin, all);
  const std::uint64_t bytes = std::min<std::uint64_t>(range.bytes.value_or(all), all - begin);
  input.seekg(static_cast<std::streamoff>(begin));
  input.read(
    mark.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(mark.size(), bytes)));
  input.clear();
  input.seekg(static_cast<std::streamoff>(begin));
  GltfDocument document;
  const bool isGlb = std::memcmp(mark.data(), "glTF", mark.size()) == 0;
  const Result<std::string> text =
    isGlb ? ReadGlb(input, begin, bytes, range.bytes.has_value(), document)
          : ReadText(input, bytes);
  KDSTREAM_TRY(text);
  Result<Json> json = ParseJson(*text, isGlb ? 20 : 0);
  KDSTREAM_TRY(json);
  document.json = std::move(*json);
  const Json& version = Member(Member(document.json, "asset"), "version");
  if (!version.is_string())
  {
    return GltfError("is not glTF: its JSON has no asset version", Remedy::Rename);
  }
  if (!version.get_ref<const std::string&>().starts_with("2"))
  {
    return GltfError("has version " + Quoted(version.get_ref<const std::string&>()) +
                       " of glTF; only version 2 can be read",
      Remedy::SaveOtherwise);
  }
  const Json& least = Member(Member(document.json, "asset"), "minVersion");
  if (least.is_string() && least != "2.0" && least != "2")
  {
    return GltfError("needs a reader for glTF " + Quoted(least.get_ref<const std::string&>()) +
                       "; this one reads 2.0",
      Remedy::SaveOtherwise);
  }
  return document;
}

const Json& Member(const Json& value, const char* name)
{
  static const Json null;
  const auto found = value.is_object() ? value.find(name) : value.end();
  return value.is_object() && found != value.end() ? *found : null;
}

double NumberOf(const Json& value, double otherwise)
{
  return value.is_number() && std::isfinite(value.get<double>()) ? value.get<double>() : otherwise;
}

double WholeOf(const Json& value, double otherwise)
{
  const double number = value.is_null() ? otherwise : NumberOf(value, -1);
  return number >= 0 && number <= 0x1p53 && number == std::floor(number) ? number : -1;
}

std::size_t CountOf(const Json& array)
{
  return array.is_array() ? array.size() : 0;
}

std::size_t IndexIn(const Json& array, const Json& index)
{
  const std::size_t size = CountOf(array);
  const double whole = WholeOf(index, -1); // 2 or 2.0
  return whole >= 0 ? static_cast<std::size_t>(std::min(whole, double(size))) : size;
}

std::optional<std::vector<std::uint8_t>> DataOf(const std::string& uri)
{
  const std::size_t comma = uri.find(',');
  const std::string_view kind = std::string_view(uri).substr(0, comma);
  if (comma == std::string::npos)
  {
    return std::nullopt;
  }
  const std::string_view written = std::string_view(uri).substr(comma + 1);
  // Also decodes % in base64: some files write "+", "/" and "=" with %.
  const std::optional<std::string> decoded = written.find('%') != std::string_view::npos
                                               ? PercentDecoded(written)
                                               : std::optional<std::string>();
  const std::string_view text = decoded ? std::string_view(*decoded) : written;
  if (!kind.ends_with(";base64"))
  {
    return std::vector<std::uint8_t>(text.begin(), text.end());
  }
  return Base64Decoded(text);
}

std::string NamesNone(const std::string& element, const Json& index, const Json& array)
{
  const std::size_t count = CountOf(array);
  return index.is_number() ? "names " + element + " " + index.dump() + ", but there " +
                               (count == 1 ? "is 1" : "are " + std::to_string(count))
                           : "names no " + element;
}

Error Within(const std::string& where, Error error)
{
  error.message = where + error.message;
  return error;
}

Status CheckGltfExtensions(const Json& json, std::optional<std::string>& notRead)
{
  std::set<std::string> names;
  for (const char* const list : { "extensionsRequired", "extensionsUsed" })
  {
    for (const Json& extension : Member(json, list))
    {
      const std::string name = extension.is_string() ? extension.get<std::string>() : "";
      const bool isRead = IsRead(name) || HasOnlyArrays(json, name);
      if (list == std::string_view("extensionsRequired") && !isRead && !ChangesLooks(name))
      {
        return Error{ ErrorCode::Unsupported,
          "needs the extension " + Quoted(name) + ", which is not read: save it without", {}, {},
          Remedy::InMessage };
      }
      if (!isRead)
      {
        names.insert(name);
      }
    }
  }
  std::string all;
  std::size_t count = 0;
  for (const std::string& name : names)
  {
    all += count < mostNamed ? (count > 0 ? ", " : "") + Quoted(name) : "";
    ++count;
  }
  all += count > mostNamed ? " and " + std::to_string(count - mostNamed) + " more" : "";
  notRead = count > 0 ? std::optional("extensions that are not read: " + all) : std::nullopt;
  return {};
}

}
