// SPDX-License-Identifier: BSD-3-Clause
// The tables of a store in SQLite, described in doc/formats.md. Only for the reader and the writer.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelJson.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The versions that are written; the second one if pieces of levels have textures.
inline constexpr int storeVersion = 13, texturedLevelsVersion = 15;
inline constexpr int newestStoreVersion = texturedLevelsVersion;
int VersionOfStore(const ModelDescription& model);

// Older versions that can still be read. In these each blob is a row of the table of its kind.
// Version 10 has textures, 11 a list of vertices that no triangle uses, 12 both. Version 14 has
// textures of levels with other texture coordinates, and all bits of the levels' colours.
inline constexpr int oldestStoreVersion = 9;
constexpr bool HasRowsOfBlobs(int version)
{
  return version < 13;
}
constexpr bool HasTextures(int version)
{
  return version == 10 || version == 12;
}
constexpr bool HasTexturedLevels(int version)
{
  return version >= 14;
}
constexpr bool HasUnused(int version)
{
  return version == 11 || version == 12;
}

inline constexpr int storeApplicationId = 0x4B445331; // "KDS1": SQLite's application_id

// Bytes of SQLite's pages, as written; the most in any version.
inline constexpr std::size_t storePageBytes = 1024, mostStorePageBytes = 4096;
constexpr std::size_t PageBytesOfStore(int version)
{
  return HasRowsOfBlobs(version) ? mostStorePageBytes : storePageBytes;
}
// The size limit of the row of metadata: servers and clients do not take longer ones.
inline constexpr std::size_t mostMetadataBytes = maximumModelBytes;

struct StoreTable
{
  std::string_view name;
  std::string_view sql; // as SQLite stores it in the schema, letter for letter
};
// The tables of a store of this version, in their order; the first is the metadata.
std::vector<StoreTable> TablesOfStore(int version);
// The statements that create them.
std::string SchemaOfStore(int version);

// All blobs, one after the other, are cut into rows of the table `content`. Each row but the last
// has this number of bytes. Together with SQLite's overhead a row fills eight pages, except for 67
// bytes.
inline constexpr std::size_t contentRowBytes = 8125;

// The number of blobs that a row of the table `directory` describes; the last row has the rest.
inline constexpr std::size_t blobsOfDirectoryRow = 80;

// Where a blob is.
struct BlobPlace
{
  std::uint64_t begin = 0; // in the content
  std::uint32_t bytes = 0;
  std::uint64_t checksum = 0; // BlobChecksum
  bool operator==(const BlobPlace&) const = default;
};
// Encodes row `part`, of consecutive blobs. REQUIRES: 1 … blobsOfDirectoryRow of them.
std::vector<std::uint8_t> EncodeDirectoryRow(std::uint64_t part, std::span<const BlobPlace> blobs);
// The inverse. Nothing if the row's checksum is wrong or its length is impossible.
std::optional<std::vector<BlobPlace>> DecodeDirectoryRow(
  std::uint64_t part, std::span<const std::uint8_t> row);
// XXH3-64 of a blob.
std::uint64_t BlobChecksum(std::span<const std::uint8_t> data);

// XXH3-64 of the key and value of the metadata; the same in all versions.
std::int64_t MetadataChecksum(std::string_view key, std::string_view value);

// ---- versions before 13

// The row of a piece in the tables of versions 9 to 12, and its key in the digest of all versions.
// The resolution (63 = original) is above the node in the number, so rows go from coarse to fine.
std::int64_t PieceRow(PieceId id);
// The inverse: nothing if no piece of any store has this row.
std::optional<PieceId> PieceOfRow(std::int64_t row);

// XXH3-64 over the columns and data of a row of tree, boxes, textures or unused. It reveals rows
// that are damaged or in the wrong place.
std::int64_t NodeChecksum(NodeId node, std::span<const std::uint8_t> data);
std::int64_t PieceChecksum(
  PieceId id, std::uint64_t vertices, std::uint64_t triangles, std::span<const std::uint8_t> data);

// The content digest: XXH3-128, as 32 hexadecimal digits. It is computed over the coordinate grid,
// the depths and the spacings of the levels, then over the kind, key and XXH3-128 of every blob.
// The order of blobs: levels coarse to fine; partitions, each directly followed by its texture if
// there are textures; textures of levels, fine to coarse; boxes; tree pages; each by ascending
// node; and the parts of the list of unused vertices.
class ContentDigest
{
public:
  explicit ContentDigest(const ModelDescription& model);
  ~ContentDigest();
  void AddTreePage(NodeId page, std::span<const std::uint8_t> data);
  void AddBoxes(NodeId node, std::span<const std::uint8_t> data);
  void AddPiece(PieceId id, std::span<const std::uint8_t> data);
  void AddTexture(std::uint32_t partition, std::span<const std::uint8_t> data);
  void AddLevelTexture(PieceId piece, std::span<const std::uint8_t> data);
  void AddUnused(std::uint32_t part, std::span<const std::uint8_t> data);
  std::string Hexadecimal() const;

private:
  void AddBlob(char kind, std::uint64_t key, std::span<const std::uint8_t> data);
  struct State;
  std::unique_ptr<State> Hash;
};

// Checks that the row "model" (WriteStoredModel) has at most mostMetadataBytes. Errors:
// LimitExceeded.
Status CheckMetadataSize(std::string_view json);

}
