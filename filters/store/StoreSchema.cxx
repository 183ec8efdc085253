// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreSchema.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <bit>
#include <new>

namespace kdstream
{
namespace
{

// Throws std::bad_alloc if there is no memory.
XXH3_state_t* MakeHashState()
{
  XXH3_state_t* const state = XXH3_createState();
  return state ? state : throw std::bad_alloc();
}

class RowHash
{
public:
  RowHash()
    : State(MakeHashState())
  {
    XXH3_64bits_reset(this->State);
  }
  RowHash(const RowHash&) = delete;
  RowHash& operator=(const RowHash&) = delete;
  ~RowHash() { XXH3_freeState(this->State); }

  RowHash& Number(std::uint64_t value)
  {
    std::array<std::uint8_t, 8> bytes;
    for (std::size_t i = 0; i < 8; ++i)
    {
      bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    return this->Bytes(bytes);
  }
  RowHash& Bytes(std::span<const std::uint8_t> bytes)
  {
    XXH3_64bits_update(this->State, bytes.data(), bytes.size());
    return *this;
  }
  RowHash& Text(std::string_view text)
  {
    this->Number(text.size());
    XXH3_64bits_update(this->State, text.data(), text.size());
    return *this;
  }
  std::int64_t Value() const
  {
    return std::bit_cast<std::int64_t>(XXH3_64bits_digest(this->State));
  }

private:
  XXH3_state_t* State;
};

}

int VersionOfStore(const ModelDescription& model)
{
  return model.textures && model.textures->levels ? texturedLevelsVersion : storeVersion;
}

std::vector<StoreTable> TablesOfStore(int version)
{
  if (!HasRowsOfBlobs(version))
  {
    return {
      { "metadata",
        "CREATE TABLE metadata (key TEXT NOT NULL, value TEXT NOT NULL, checksum INTEGER NOT "
        "NULL)" },
      { "directory", "CREATE TABLE directory (part INTEGER PRIMARY KEY, data BLOB NOT NULL)" },
      { "content", "CREATE TABLE content (part INTEGER PRIMARY KEY, data BLOB NOT NULL)" },
    };
  }
  std::vector<StoreTable> tables{
    { "metadata",
      "CREATE TABLE metadata (key TEXT PRIMARY KEY, value TEXT NOT NULL, checksum INTEGER NOT "
      "NULL) WITHOUT ROWID" },
  };
  tables.push_back({ "tree", "CREATE TABLE tree (page INTEGER PRIMARY KEY, data BLOB NOT NULL, "
                             "checksum INTEGER NOT NULL)" });
  tables.push_back({ "boxes", "CREATE TABLE boxes (node INTEGER PRIMARY KEY, data BLOB NOT NULL, "
                              "checksum INTEGER NOT NULL)" });
  tables.push_back({ "pieces",
    "CREATE TABLE pieces (id INTEGER PRIMARY KEY, resolution INTEGER NOT NULL, node INTEGER NOT "
    "NULL,\n  vertices INTEGER NOT NULL, triangles INTEGER NOT NULL, data BLOB NOT NULL, checksum "
    "INTEGER NOT NULL)" });
  if (HasTextures(version))
  {
    tables.push_back({ "textures", "CREATE TABLE textures (partition INTEGER PRIMARY KEY, data "
                                   "BLOB NOT NULL, checksum INTEGER NOT NULL)" });
  }
  if (HasUnused(version))
  {
    tables.push_back({ "unused", "CREATE TABLE unused (part INTEGER PRIMARY KEY, data BLOB NOT "
                                 "NULL, checksum INTEGER NOT NULL)" });
  }
  return tables;
}

std::string SchemaOfStore(int version)
{
  std::string schema;
  for (const StoreTable& table : TablesOfStore(version))
  {
    schema += table.sql;
    schema += ";\n";
  }
  return schema;
}

namespace
{

// Little-endian numbers, one after the other.
template <class T>
void Put(std::vector<std::uint8_t>& bytes, T number)
{
  for (std::size_t i = 0; i < sizeof(T); ++i)
  {
    bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
  }
}

template <class T>
T Take(std::span<const std::uint8_t>& bytes)
{
  T number = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
  {
    number |= static_cast<T>(T{ bytes[i] } << (8 * i));
  }
  bytes = bytes.subspan(sizeof(T));
  return number;
}

constexpr std::size_t placeBytes = 12;
constexpr std::size_t aroundPlaces = 16; // where the first blob begins, and the checksum of the row

}

std::vector<std::uint8_t> EncodeDirectoryRow(std::uint64_t part, std::span<const BlobPlace> blobs)
{
  std::vector<std::uint8_t> row;
  row.reserve(aroundPlaces + placeBytes * blobs.size());
  Put(row, blobs.front().begin);
  for (const BlobPlace& blob : blobs)
  {
    Put(row, blob.bytes);
    Put(row, blob.checksum);
  }
  Put(row, XXH3_64bits_withSeed(row.data(), row.size(), part));
  return row;
}

std::optional<std::vector<BlobPlace>> DecodeDirectoryRow(
  std::uint64_t part, std::span<const std::uint8_t> row)
{
  if (row.size() < aroundPlaces + placeBytes || (row.size() - aroundPlaces) % placeBytes != 0 ||
      row.size() > aroundPlaces + placeBytes * blobsOfDirectoryRow)
  {
    return {};
  }
  std::span<const std::uint8_t> checksum = row.last(8), left = row.first(row.size() - 8);
  if (Take<std::uint64_t>(checksum) != XXH3_64bits_withSeed(left.data(), left.size(), part))
  {
    return {};
  }
  std::vector<BlobPlace> blobs;
  blobs.reserve(left.size() / placeBytes);
  auto begin = Take<std::uint64_t>(left);
  while (!left.empty())
  {
    BlobPlace& blob = blobs.emplace_back();
    blob.begin = begin;
    blob.bytes = Take<std::uint32_t>(left);
    blob.checksum = Take<std::uint64_t>(left);
    begin += blob.bytes;
  }
  return blobs;
}

std::uint64_t BlobChecksum(std::span<const std::uint8_t> data)
{
  return XXH3_64bits(data.data(), data.size());
}

std::int64_t PieceRow(PieceId id)
{
  const std::int64_t resolution = id.resolution.IsOriginal()
                                    ? Resolution::maximumLevel + 1
                                    : static_cast<int>(id.resolution.Depth());
  return (resolution << 32) | id.node;
}

std::optional<PieceId> PieceOfRow(std::int64_t row)
{
  const std::int64_t resolution = row >> 32;
  if (resolution < 0 || resolution > Resolution::maximumLevel + 1)
  {
    return {};
  }
  return PieceId{ resolution > Resolution::maximumLevel
                    ? Resolution::Original()
                    : Resolution::Level(static_cast<unsigned>(resolution)),
    static_cast<NodeId>(row & 0xFFFFFFFF) };
}

std::int64_t MetadataChecksum(std::string_view key, std::string_view value)
{
  return RowHash().Text(key).Text(value).Value();
}

Status CheckMetadataSize(std::string_view json)
{
  return json.size() <= mostMetadataBytes
           ? Status{}
           : Error{ ErrorCode::LimitExceeded,
               "its texts take " + std::to_string(json.size()) +
                 " bytes together with its other metadata; the maximum is " +
                 std::to_string(mostMetadataBytes) };
}

std::int64_t NodeChecksum(NodeId node, std::span<const std::uint8_t> data)
{
  return RowHash().Number(node).Bytes(data).Value();
}

std::int64_t PieceChecksum(
  PieceId id, std::uint64_t vertices, std::uint64_t triangles, std::span<const std::uint8_t> data)
{
  const auto row = static_cast<std::uint64_t>(PieceRow(id));
  return RowHash().Number(row).Number(vertices).Number(triangles).Bytes(data).Value();
}

struct ContentDigest::State
{
  State()
    : Xxh(MakeHashState())
  {
    XXH3_128bits_reset(this->Xxh);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { XXH3_freeState(this->Xxh); }

  void Number(std::uint64_t value)
  {
    std::array<std::uint8_t, 8> bytes;
    for (std::size_t i = 0; i < 8; ++i)
    {
      bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    XXH3_128bits_update(this->Xxh, bytes.data(), bytes.size());
  }

  XXH3_state_t* Xxh;
};

ContentDigest::ContentDigest(const ModelDescription& model)
  : Hash(std::make_unique<State>())
{
  this->Hash->Number(model.depths.partition);
  this->Hash->Number(model.depths.stitch);
  this->Hash->Number(model.depths.finest);
  this->Hash->Number(model.grid.bits);
  this->Hash->Number(static_cast<std::uint64_t>(model.grid.scalarType));
  for (const double value :
    { model.grid.origin[0], model.grid.origin[1], model.grid.origin[2], model.grid.step })
  {
    this->Hash->Number(std::bit_cast<std::uint64_t>(value));
  }
  for (const ResolutionDescription& level : model.levels)
  {
    this->Hash->Number(level.spacing);
  }
}

ContentDigest::~ContentDigest() = default;

void ContentDigest::AddTreePage(NodeId page, std::span<const std::uint8_t> data)
{
  this->AddBlob('t', page, data);
}

void ContentDigest::AddBoxes(NodeId node, std::span<const std::uint8_t> data)
{
  this->AddBlob('b', node, data);
}

void ContentDigest::AddPiece(PieceId id, std::span<const std::uint8_t> data)
{
  this->AddBlob('p', static_cast<std::uint64_t>(PieceRow(id)), data);
}

void ContentDigest::AddTexture(std::uint32_t partition, std::span<const std::uint8_t> data)
{
  this->AddBlob('x', partition, data);
}

void ContentDigest::AddLevelTexture(PieceId piece, std::span<const std::uint8_t> data)
{
  this->AddBlob('y', static_cast<std::uint64_t>(PieceRow(piece)), data);
}

void ContentDigest::AddUnused(std::uint32_t part, std::span<const std::uint8_t> data)
{
  this->AddBlob('u', part, data);
}

void ContentDigest::AddBlob(char kind, std::uint64_t key, std::span<const std::uint8_t> data)
{
  const XXH128_hash_t hash = XXH3_128bits(data.data(), data.size());
  this->Hash->Number(static_cast<std::uint64_t>(kind));
  this->Hash->Number(key);
  this->Hash->Number(hash.high64);
  this->Hash->Number(hash.low64);
}

std::string ContentDigest::Hexadecimal() const
{
  const XXH128_hash_t hash = XXH3_128bits_digest(this->Hash->Xxh);
  std::string text;
  for (const std::uint64_t half : { hash.high64, hash.low64 })
  {
    for (int shift = 60; shift >= 0; shift -= 4)
    {
      text += "0123456789abcdef"[(half >> shift) & 15];
    }
  }
  return text;
}

}
