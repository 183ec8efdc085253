// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. read the header, the JSON and the binary part
// 2. read the buffers, some of which may be other files
// 3. read the bits of tiles, contents and children.
#include "filters/convert/tiles/Subtree.h"

#include "filters/convert/gltf/GltfDocument.h"

#include <algorithm>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr std::uint64_t mostSubtreeBytes = std::uint64_t{ 1 } << 28;

class SubtreeReader
{
public:
  SubtreeReader(const TilesetFolder& folder, std::filesystem::path file)
    : Folder(folder)
    , File(std::move(file))
  {
  }

  Result<Subtree> Read(const SubtreeShape& shape)
  {
    KDSTREAM_TRY(this->Open());
    Subtree subtree;
    Result<TileBits> tiles = this->BitsOf(Member(this->Head, "tileAvailability"), shape.tiles);
    KDSTREAM_TRY(tiles);
    Result<TileBits> children =
      this->BitsOf(Member(this->Head, "childSubtreeAvailability"), shape.children);
    KDSTREAM_TRY(children);
    const Json& several = Member(
      Member(Member(this->Head, "extensions"), "3DTILES_multiple_contents"), "contentAvailability");
    const Json& contents = several.is_null() ? Member(this->Head, "contentAvailability") : several;
    for (std::size_t i = 0; i < std::min(CountOf(contents), mostContents); ++i)
    {
      Result<TileBits> bits = this->BitsOf(contents[i], shape.tiles);
      KDSTREAM_TRY(bits);
      subtree.contents.push_back(std::move(*bits));
    }
    if (contents.is_object()) // as before version 1.1
    {
      Result<TileBits> bits = this->BitsOf(contents, shape.tiles);
      KDSTREAM_TRY(bits);
      subtree.contents.push_back(std::move(*bits));
    }
    subtree.tiles = std::move(*tiles);
    subtree.children = std::move(*children);
    return subtree;
  }

private:
  static constexpr std::size_t mostContents = 64;

  Status Open()
  {
    Result<std::string> read = ReadTileText(this->Folder.PathOf(this->File), mostSubtreeBytes);
    KDSTREAM_TRY(read);
    const std::string_view bytes = *read;
    std::string_view text = bytes;
    if (bytes.starts_with("subt"))
    {
      constexpr std::size_t headBytes = 24;
      if (bytes.size() < headBytes)
      {
        return BadInput("ends inside its header", Remedy::CopyAgain);
      }
      const std::uint64_t json = NumberInTile(bytes, 8, 8), binary = NumberInTile(bytes, 16, 8);
      const std::uint64_t left = bytes.size() - headBytes;
      if (json > left || binary > left - json)
      {
        return BadInput("claims " + std::to_string(json) + " bytes of JSON and " +
                          std::to_string(binary) + " others; it has " + std::to_string(left),
          Remedy::CopyAgain);
      }
      text = bytes.substr(headBytes, static_cast<std::size_t>(json));
      this->Binary =
        bytes.substr(headBytes + static_cast<std::size_t>(json), static_cast<std::size_t>(binary));
    }
    Result<Json> json = ParseTileJson(text);
    KDSTREAM_TRY(json);
    this->Head = std::move(*json);
    return {};
  }

  // The bytes of a buffer; a buffer without a URI is the binary part.
  Result<std::string> BytesOf(const Json& buffer)
  {
    const Json& uri = Member(buffer, "uri");
    if (!uri.is_string())
    {
      return this->Binary;
    }
    const auto file = this->Folder.Find(this->File, uri.get<std::string>());
    KDSTREAM_TRY(file);
    return ReadTileText(this->Folder.PathOf(*file), mostSubtreeBytes);
  }

  Result<TileBits> BitsOf(const Json& availability, std::size_t count)
  {
    const Json& constant = Member(availability, "constant");
    if (!constant.is_null())
    {
      return TileBits(constant == 1);
    }
    const Json& old = Member(availability, "bufferView"); // as before version 1.1
    const Json& number = old.is_null() ? Member(availability, "bitstream") : old;
    const Json& views = Member(this->Head, "bufferViews");
    const std::size_t view = IndexIn(views, number);
    if (view == CountOf(views))
    {
      return GltfError("has an availability that " + NamesNone("bufferView", number, views));
    }
    const Json& buffers = Member(this->Head, "buffers");
    const Json& place = Member(views[view], "buffer");
    const std::size_t buffer = IndexIn(buffers, place);
    if (buffer == CountOf(buffers))
    {
      return GltfError("has a bufferView that " + NamesNone("buffer", place, buffers));
    }
    Result<std::string> bytes = this->BytesOf(buffers[buffer]);
    KDSTREAM_TRY(bytes);
    const double offset = WholeOf(Member(views[view], "byteOffset"), 0);
    const double length = WholeOf(Member(views[view], "byteLength"), -1);
    const std::size_t needed = (count + 7) / 8;
    if (offset < 0 || length < double(needed) || offset + length > double(bytes->size()))
    {
      return GltfError(
        "has no " + std::to_string(count) + " bits in its bufferView " + std::to_string(view));
    }
    return TileBits(bytes->substr(static_cast<std::size_t>(offset), needed));
  }

  const TilesetFolder& Folder;
  const std::filesystem::path File;
  Json Head;
  std::string Binary;
};

}

Result<Subtree> ReadSubtree(
  const TilesetFolder& folder, const std::filesystem::path& file, const SubtreeShape& shape)
{
  return SubtreeReader(folder, file).Read(shape);
}

}
