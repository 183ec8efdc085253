// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/tiles/TileParts.h"

#include "filters/convert/tiles/TilesetFolder.h"
#include "filters/core/BitCast.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string_view>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

constexpr std::uint64_t composedHead = 16, batchedHead = 28;
constexpr std::uint64_t mostTableBytes = std::uint64_t{ 1 } << 28;
constexpr std::size_t mostParts = std::size_t{ 1 } << 16;

class TilePartsReader
{
public:
  explicit TilePartsReader(const std::filesystem::path& file)
    : Input(file, std::ios::binary)
  {
    std::error_code failed;
    const std::uintmax_t size = std::filesystem::file_size(file, failed);
    this->Size = failed || !this->Input ? 0 : size;
    this->IsThere = !failed && this->Input;
  }

  Result<TileParts> Read()
  {
    if (!this->IsThere)
    {
      return Error{ ErrorCode::InputOutput, "cannot be read" };
    }
    // The tiles still to be read. A composite is replaced by the tiles that it contains.
    std::vector<GltfRange> left{ { 0, this->Size } };
    while (!left.empty())
    {
      const GltfRange tile = left.back();
      left.pop_back();
      KDSTREAM_TRY(this->ReadTile(tile, left));
      if (this->Found.parts.size() + left.size() > mostParts)
      {
        return Error{ ErrorCode::LimitExceeded,
          "holds more than " + std::to_string(mostParts) + " tiles" };
      }
    }
    return std::move(this->Found);
  }

private:
  Result<std::string> Bytes(std::uint64_t begin, std::uint64_t size)
  {
    std::string bytes(static_cast<std::size_t>(size), '\0');
    this->Input.clear();
    this->Input.seekg(static_cast<std::streamoff>(begin));
    return this->Input.read(bytes.data(), static_cast<std::streamsize>(size))
             ? Result<std::string>(std::move(bytes))
             : Error{ ErrorCode::InputOutput, "cannot be read" };
  }

  // REQUIRES: `tile` lies in the file.
  Status ReadTile(const GltfRange& tile, std::vector<GltfRange>& left)
  {
    const std::uint64_t size = *tile.bytes;
    const Result<std::string> head = this->Bytes(tile.begin, std::min(size, batchedHead));
    KDSTREAM_TRY(head);
    const std::string kind = head->substr(0, 4);
    const bool isWhole = tile.begin == 0 && size == this->Size;
    if (kind == "b3dm")
    {
      return this->ReadBatched(tile, *head);
    }
    if (kind == "cmpt")
    {
      return this->ReadComposite(tile, *head, left);
    }
    if (kind == "pnts" || kind == "i3dm" || kind == "vctr" || kind == "geom")
    {
      this->Found.notRead.insert(kind);
      return {};
    }
    if (kind.starts_with("\x1f\x8b"))
    {
      return BadInput("is compressed by gzip: unpack the tileset", Remedy::InMessage);
    }
    this->Found.parts.push_back({ isWhole ? GltfRange{} : tile, {} });
    return {};
  }

  // Checks that the header claims version 1, and no more bytes than the tile has.
  static Status CheckHead(std::string_view head, std::uint64_t headBytes, std::uint64_t size)
  {
    if (head.size() < headBytes)
    {
      return BadInput("ends inside its header", Remedy::CopyAgain);
    }
    const std::uint64_t version = NumberInTile(head, 4, 4), claimed = NumberInTile(head, 8, 4);
    if (version != 1)
    {
      return BadInput(
        "has version " + std::to_string(version) + " of its format; only version 1 can be read",
        Remedy::SaveOtherwise);
    }
    return claimed >= headBytes && claimed <= size
             ? Status{}
             : Status(BadInput(
                 "claims " + std::to_string(claimed) + " bytes; it has " + std::to_string(size),
                 Remedy::CopyAgain));
  }

  Status ReadBatched(const GltfRange& tile, std::string_view head)
  {
    KDSTREAM_TRY(CheckHead(head, batchedHead, *tile.bytes));
    const std::uint64_t all = NumberInTile(head, 8, 4);
    std::uint64_t sum = batchedHead;
    std::array<std::uint64_t, 4> tables{}; // of features: JSON, numbers; of batches
    for (std::size_t i = 0; i < tables.size(); ++i)
    {
      tables[i] = NumberInTile(head, 12 + 4 * i, 4);
      sum += tables[i];
    }
    if (sum > all || tables[0] > mostTableBytes || tables[2] > mostTableBytes)
    {
      const Result<bool> isOld = this->ReadOldBatched(tile, head);
      KDSTREAM_TRY(isOld);
      if (*isOld)
      {
        return {};
      }
      return BadInput("claims tables of " + std::to_string(sum - batchedHead) + " bytes; it has " +
                        std::to_string(all),
        Remedy::Repair);
    }
    const std::uint64_t features = tile.begin + batchedHead;
    TilePart part{ { tile.begin + sum, all - sum }, {} };
    KDSTREAM_TRY(this->ReadCenter(features, tables[0], tables[1], part.center));
    KDSTREAM_TRY(this->ReadProperties(features + tables[0] + tables[1], tables[2]));
    this->Found.parts.push_back(part);
    return {};
  }

  // Reads a b3dm from before version 1.0. Its header has fewer numbers, and the glTF follows the
  // batch table.
  Result<bool> ReadOldBatched(const GltfRange& tile, std::string_view head)
  {
    const std::uint64_t all = NumberInTile(head, 8, 4);
    const std::uint64_t first = NumberInTile(head, 12, 4), second = NumberInTile(head, 16, 4);
    struct Old
    {
      std::uint64_t head, json, numbers;
    };
    for (const auto& [bytes, json, numbers] : { Old{ 20, second, 0 }, Old{ 24, first, second } })
    {
      constexpr std::string_view mark = "glTF";
      const std::uint64_t begin = bytes + json + numbers;
      if (begin + mark.size() > all || json > mostTableBytes)
      {
        continue;
      }
      const Result<std::string> found = this->Bytes(tile.begin + begin, mark.size());
      KDSTREAM_TRY(found);
      if (*found == mark)
      {
        KDSTREAM_TRY(this->ReadProperties(tile.begin + bytes, json));
        this->Found.parts.push_back({ { tile.begin + begin, all - begin }, {} });
        return true;
      }
    }
    return false;
  }

  // A table's JSON; null if there is no table.
  Result<Json> Table(std::uint64_t begin, std::uint64_t size)
  {
    const Result<std::string> text = this->Bytes(begin, size);
    KDSTREAM_TRY(text);
    if (text->find_first_not_of(std::string_view("\0 \n", 3)) == std::string::npos)
    {
      return Json();
    }
    Result<Json> json = ParseTileJson(*text);
    return json ? std::move(json)
                : Result<Json>(Within("has a table that cannot be read: ", json.GetError()));
  }

  // Reads the feature table's RTC_CENTER, from its JSON, or as floats from its binary part.
  Status ReadCenter(std::uint64_t begin, std::uint64_t size, std::uint64_t numbers, Vec3& center)
  {
    const Result<Json> table = this->Table(begin, size);
    KDSTREAM_TRY(table);
    const Json& reported = Member(*table, "RTC_CENTER");
    const double offset = WholeOf(Member(reported, "byteOffset"), -1);
    constexpr std::uint64_t bytes = 12;
    if (reported.is_object() && offset >= 0 && offset + bytes <= double(numbers))
    {
      const Result<std::string> floats =
        this->Bytes(begin + size + static_cast<std::uint64_t>(offset), bytes);
      KDSTREAM_TRY(floats);
      for (std::size_t k = 0; k < 3; ++k)
      {
        center[k] = BitCast<float>(static_cast<std::uint32_t>(NumberInTile(*floats, 4 * k, 4)));
      }
      return {};
    }
    const bool isRight =
      reported.is_null() ||
      (CountOf(reported) == 3 && std::all_of(reported.begin(), reported.end(),
                                   [](const Json& number) { return number.is_number(); }));
    if (!isRight)
    {
      return BadInput("has an RTC_CENTER that does not have 3 numbers", Remedy::Repair);
    }
    for (std::size_t k = 0; k < CountOf(reported); ++k)
    {
      center[k] = reported[k].get<double>();
    }
    return {};
  }

  Status ReadProperties(std::uint64_t begin, std::uint64_t size)
  {
    const Result<Json> table = this->Table(begin, size);
    KDSTREAM_TRY(table);
    constexpr std::size_t most = 64;
    for (const auto& [name, value] : table->items())
    {
      if (this->Found.properties.size() < most && name != "extensions" && name != "extras")
      {
        this->Found.properties.insert(name);
      }
    }
    return {};
  }

  Status ReadComposite(const GltfRange& tile, std::string_view head, std::vector<GltfRange>& left)
  {
    KDSTREAM_TRY(CheckHead(head, composedHead, *tile.bytes));
    const std::uint64_t end = tile.begin + NumberInTile(head, 8, 4);
    const std::uint64_t count = NumberInTile(head, 12, 4);
    std::uint64_t at = tile.begin + composedHead;
    std::vector<GltfRange> inner;
    for (std::uint64_t i = 0; i < count; ++i)
    {
      constexpr std::uint64_t least = 12; // the header bytes that all tiles have
      const Result<std::string> begin =
        end - at < least ? Result<std::string>(std::string()) : this->Bytes(at, least);
      KDSTREAM_TRY(begin);
      const std::uint64_t size = begin->empty() ? 0 : NumberInTile(*begin, 8, 4);
      if (size < least || size > end - at || inner.size() == mostParts)
      {
        return BadInput("claims " + std::to_string(count) + " tiles, but has no room for tile " +
                          std::to_string(i),
          Remedy::Repair);
      }
      inner.push_back({ at, size });
      at += size;
    }
    left.insert(left.end(), inner.rbegin(), inner.rend());
    return {};
  }

  std::ifstream Input;
  std::uint64_t Size = 0;
  bool IsThere = false;
  TileParts Found;
};

}

Result<TileParts> FindTileParts(const std::filesystem::path& file)
{
  return TilePartsReader(file).Read();
}

}
