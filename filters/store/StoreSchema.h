// SPDX-License-Identifier: BSD-3-Clause
// The layout of a store inside SQLite, for the reader and the writer alone. Described in
// doc/formats.md.
#pragma once

#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace kdstream
{

inline constexpr int storeVersion = 9;
inline constexpr int texturedStoreVersion = 10;       // that has textures too
inline constexpr int storeApplicationId = 0x4B445331; // "KDS1": SQLite's application_id

inline constexpr const char* storeSchema = R"(
CREATE TABLE metadata (key TEXT PRIMARY KEY, value TEXT NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE tree (page INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE boxes (node INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE pieces (id INTEGER PRIMARY KEY, resolution INTEGER NOT NULL, node INTEGER NOT NULL,
  vertices INTEGER NOT NULL, triangles INTEGER NOT NULL, data BLOB NOT NULL, checksum INTEGER NOT NULL);
)";
// Of a store of that version, besides.
inline constexpr const char* textureSchema = R"(
CREATE TABLE textures (partition INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER NOT NULL);
)";

// The row of a piece: its resolution (63 = original) above its node, so that rows lie coarse to
// fine.
std::int64_t PieceRow(PieceId id);
// Back: nothing where no piece of any store has that row.
std::optional<PieceId> PieceOfRow(std::int64_t row);

// XXH3-64 over what a row says and its data, so that a row that is damaged or in the wrong place is
// noticed.
std::int64_t MetadataChecksum(std::string_view key, std::string_view value);
// Of a row of tree, boxes or textures.
std::int64_t NodeChecksum(NodeId node, std::span<const std::uint8_t> data);
std::int64_t PieceChecksum(
  PieceId id, std::uint64_t vertices, std::uint64_t triangles, std::span<const std::uint8_t> data);

// The content digest: XXH3-128, as 32 hexadecimal digits, over the coordinate grid, depths and the
// levels' spacings, and then over the kind, key and XXH3-128 of every blob: levels coarse to fine,
// partitions (each with its texture behind it, if there are textures), boxes, tree pages, each by
// ascending node.
class ContentDigest
{
public:
  explicit ContentDigest(const ModelDescription& model);
  ~ContentDigest();
  void AddTreePage(NodeId page, std::span<const std::uint8_t> data);
  void AddBoxes(NodeId node, std::span<const std::uint8_t> data);
  void AddPiece(PieceId id, std::span<const std::uint8_t> data);
  void AddTexture(std::uint32_t partition, std::span<const std::uint8_t> data);
  std::string Hexadecimal() const;

private:
  void AddBlob(char kind, std::uint64_t key, std::span<const std::uint8_t> data);
  struct State;
  std::unique_ptr<State> Hash;
};

// The value of the row "model"; ParseStoredModel (ModelJson.h) is the way back.
std::string MetadataOf(const ModelDescription& model);

}
