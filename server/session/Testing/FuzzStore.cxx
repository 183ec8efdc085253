// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to stores: the input is a store's file. It is served as a server would, blob by
// blob, and read and verified as a program would. Mutations change bytes, or the columns of a row,
// with a corrected checksum, so that code after the checksums is reached. Others change the schema;
// if the store can still be opened, SQLite itself must see a store's schema.
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/Seal.h"
#include "filters/codec/TreePage.h"
#include "filters/store/Store.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/StoreSchema.h"
#include "server/session/BlobList.h"
#include "server/session/StoreCatalog.h"

#include <sqlite3.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

using namespace kdstream;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Opening a store waits if the file was written in the last 20 ms. So the clock is a second ahead
// of file times here; otherwise there would be only fifty runs a second.
extern "C" int clock_gettime(clockid_t clock, timespec* time)
{
  const auto result = static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
  time->tv_sec += clock == CLOCK_REALTIME ? 1 : 0;
  return result;
}

namespace
{

constexpr std::size_t mostBlobs = 500;

void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::fprintf(stderr, "FuzzStore: %s\n", what);
    std::abort();
  }
}

// The folder is in memory if the system has such a file system.
class Folder
{
public:
  Folder()
    : Path((std::filesystem::exists("/dev/shm") ? "/dev/shm"
                                                : std::filesystem::temp_directory_path()) /
           ("kdstream-fuzz-" + std::to_string(::getpid())))
  {
    std::filesystem::create_directories(this->Path);
  }
  ~Folder() { std::filesystem::remove_all(this->Path); }
  const std::filesystem::path Path;
};

std::vector<protocol::BlobId> BlobsOf(const ModelDescription& model)
{
  using protocol::BlobId;
  std::vector<BlobId> blobs;
  for (const NodeId page : TreePages(model.depths))
  {
    blobs.push_back(BlobId::TreePage(page));
  }
  for (const NodeId node : AllPartitionBoxes(model.depths))
  {
    blobs.push_back(BlobId::PartitionBoxes(node));
  }
  for (std::uint8_t level = 0; level < model.levels.size(); ++level)
  {
    const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(level), model.depths);
    for (NodeId node = first; node < 2 * first && blobs.size() < mostBlobs; ++node)
    {
      blobs.push_back(BlobId::LevelPiece(level, node));
    }
  }
  for (std::uint32_t p = 0; p < model.partitions && blobs.size() < 2 * mostBlobs; ++p)
  {
    blobs.push_back(BlobId::Partition(p));
  }
  return blobs;
}

void Serve(const ServedModel& model)
{
  (void)model.Json()->size();
  (void)model.CheckUnchanged().HasValue();
  (void)model.Boxes().HasValue();
  for (const auto& id : BlobsOf(model.Description()))
  {
    const auto size = model.BlobSize(id); // before reading, which puts the blob into memory
    const auto bytes = model.ReadBlob(id);
    Require(!bytes || (size && *size == (*bytes)->size()), "a blob of another size");
    Require(bytes || !bytes.GetError().message.empty(), "an error without a message");
  }
  const protocol::ClientMessage region{ 1, protocol::RegionRequest{ 1, 3, {} } };
  (void)ListBlobs(model, region, 1000).HasValue();
}

struct CloseConnection
{
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinalizeStatement
{
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Connection = std::unique_ptr<sqlite3, CloseConnection>;
using Query = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// The bytes as a database in memory; null if they are not a database.
Connection Deserialized(const std::uint8_t* data, std::size_t size)
{
  sqlite3* raw = nullptr;
  Connection database(sqlite3_open(":memory:", &raw) == SQLITE_OK ? raw : nullptr);
  auto* copy = static_cast<unsigned char*>(sqlite3_malloc64(size));
  std::memcpy(copy, data, size);
  const auto bytes = static_cast<sqlite3_int64>(size);
  const int status = sqlite3_deserialize(raw, "main", copy, bytes, bytes,
    SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_RESIZEABLE);
  return status == SQLITE_OK ? std::move(database) : nullptr;
}

Query Prepared(sqlite3* database, const std::string& sql)
{
  sqlite3_stmt* raw = nullptr;
  sqlite3_prepare_v2(database, sql.c_str(), -1, &raw, nullptr);
  return Query(raw);
}

std::vector<std::uint8_t> Mutated(std::span<const std::uint8_t> bytes)
{
  std::vector<std::uint8_t> mutated(bytes.begin(), bytes.end());
  mutated.resize(bytes.size() + 64);
  mutated.resize(LLVMFuzzerMutate(mutated.data(), bytes.size(), mutated.size()));
  return mutated;
}

std::span<const std::uint8_t> BlobOf(sqlite3_stmt* row, int column)
{
  return { static_cast<const std::uint8_t*>(sqlite3_column_blob(row, column)),
    static_cast<std::size_t>(sqlite3_column_bytes(row, column)) };
}

bool Update(sqlite3* database, const std::string& sql, std::span<const std::uint8_t> data,
  std::int64_t checksum, std::int64_t key)
{
  const auto update = Prepared(database, sql);
  sqlite3_bind_blob64(update.get(), 1, data.data(), data.size(), SQLITE_TRANSIENT);
  sqlite3_bind_int64(update.get(), 2, checksum);
  sqlite3_bind_int64(update.get(), 3, key);
  return sqlite3_step(update.get()) == SQLITE_DONE;
}

bool MutateMetadata(sqlite3* database)
{
  const auto row = Prepared(database, "SELECT value FROM metadata WHERE key = 'model'");
  if (sqlite3_step(row.get()) != SQLITE_ROW)
  {
    return false;
  }
  const auto json = Mutated(BlobOf(row.get(), 0));
  const std::string text(json.begin(), json.end());
  return Update(database,
    "UPDATE metadata SET value = CAST(?1 AS TEXT), checksum = ?2 WHERE key = 'model' OR ?3 = 1",
    json, MetadataChecksum("model", text), 0);
}

// A mutated blob. If the blob ends with a checksum of its own, the checksum is corrected.
std::vector<std::uint8_t> MutatedBlob(std::span<const std::uint8_t> blob)
{
  if (!IsSealed(blob))
  {
    return Mutated(blob);
  }
  auto mutated = Mutated(blob.first(blob.size() - checksumSize));
  SealBlob(mutated);
  return mutated;
}

bool MutatePiece(sqlite3* database, std::uint64_t choice)
{
  const auto row = Prepared(
    database, "SELECT id, vertices, triangles, data FROM pieces ORDER BY id LIMIT 1 OFFSET " +
                std::to_string(choice % 16));
  if (sqlite3_step(row.get()) != SQLITE_ROW)
  {
    return false;
  }
  const auto id = sqlite3_column_int64(row.get(), 0);
  const auto piece = PieceOfRow(id);
  const auto data = MutatedBlob(BlobOf(row.get(), 3));
  return piece &&
         Update(database, "UPDATE pieces SET data = ?1, checksum = ?2 WHERE id = ?3", data,
           PieceChecksum(*piece, static_cast<std::uint64_t>(sqlite3_column_int64(row.get(), 1)),
             static_cast<std::uint64_t>(sqlite3_column_int64(row.get(), 2)), data),
           id);
}

bool MutateNode(
  sqlite3* database, const std::string& table, const std::string& key, std::uint64_t choice)
{
  const auto row = Prepared(database, "SELECT " + key + ", data FROM " + table + " ORDER BY " +
                                        key + " LIMIT 1 OFFSET " + std::to_string(choice % 4));
  if (sqlite3_step(row.get()) != SQLITE_ROW)
  {
    return false;
  }
  const auto node = sqlite3_column_int64(row.get(), 0);
  const auto data = MutatedBlob(BlobOf(row.get(), 1));
  return Update(database,
    "UPDATE " + table + " SET data = ?1, checksum = ?2 WHERE " + key + " = ?3", data,
    NodeChecksum(static_cast<NodeId>(node), data), node);
}

std::vector<std::vector<std::uint8_t>> RowsOf(sqlite3* database, const char* select)
{
  std::vector<std::vector<std::uint8_t>> rows;
  const auto row = Prepared(database, select);
  while (row && sqlite3_step(row.get()) == SQLITE_ROW)
  {
    const auto data = BlobOf(row.get(), 0);
    rows.emplace_back(data.begin(), data.end());
  }
  return rows;
}

bool Insert(
  sqlite3* database, const char* sql, std::size_t part, std::span<const std::uint8_t> data)
{
  const auto insert = Prepared(database, sql);
  sqlite3_bind_int64(insert.get(), 1, static_cast<sqlite3_int64>(part));
  sqlite3_bind_blob64(insert.get(), 2, data.data(), data.size(), SQLITE_TRANSIENT);
  return sqlite3_step(insert.get()) == SQLITE_DONE;
}

// Changes a blob, or a blob's place, in a store that has a directory.
bool MutateContent(sqlite3* database, std::uint64_t choice)
{
  std::vector<std::uint8_t> content;
  for (const auto& row : RowsOf(database, "SELECT data FROM content ORDER BY part"))
  {
    content.insert(content.end(), row.begin(), row.end());
  }
  std::vector<std::vector<BlobPlace>> directory;
  for (const auto& row : RowsOf(database, "SELECT data FROM directory ORDER BY part"))
  {
    directory.push_back(
      DecodeDirectoryRow(directory.size(), row).value_or(std::vector<BlobPlace>()));
  }
  if (directory.empty() || directory[0].empty())
  {
    return false;
  }
  BlobPlace& place = directory[0][choice / 8 % directory[0].size()];
  if (choice % 8 == 0)
  {
    place.begin = choice >> 16;
  }
  else if (choice % 8 == 1)
  {
    place.bytes = static_cast<std::uint32_t>(choice >> 16);
  }
  else if (place.begin + place.bytes <= content.size())
  {
    const auto begin = content.begin() + static_cast<std::ptrdiff_t>(place.begin);
    const auto blob = MutatedBlob({ begin, begin + place.bytes });
    content.insert(content.erase(begin, begin + place.bytes), blob.begin(), blob.end());
    place.bytes = static_cast<std::uint32_t>(blob.size());
    place.checksum = BlobChecksum(blob);
  }
  bool done = sqlite3_exec(database, "DELETE FROM directory; DELETE FROM content", nullptr, nullptr,
                nullptr) == SQLITE_OK;
  for (std::size_t part = 0; part < directory.size() && !directory[part].empty(); ++part)
  {
    done = done && Insert(database, "INSERT INTO directory VALUES (?, ?)", part,
                     EncodeDirectoryRow(part, directory[part]));
  }
  for (std::size_t at = 0; at < content.size(); at += contentRowBytes)
  {
    done =
      done && Insert(database, "INSERT INTO content VALUES (?, ?)", at / contentRowBytes,
                std::span(content).subspan(at, std::min(contentRowBytes, content.size() - at)));
  }
  return done;
}

// Changes of the schema. Each must end by itself if a later mutation of a row runs it.
constexpr std::array schemaChanges{
  "ALTER TABLE metadata RENAME TO m; CREATE VIEW metadata AS SELECT * FROM m",
  "ALTER TABLE pieces RENAME TO p; CREATE VIEW pieces AS SELECT * FROM p",
  "ALTER TABLE content RENAME TO c; CREATE VIEW content AS SELECT * FROM c",
  "CREATE VIEW v AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT x FROM "
  "c",
  "CREATE TRIGGER t AFTER UPDATE ON metadata BEGIN DELETE FROM tree; END",
  "CREATE INDEX i ON pieces(abs(node)) WHERE node > 1",
  "CREATE UNIQUE INDEX j ON tree(checksum)",
  "CREATE INDEX k ON content(length(data))",
  "ALTER TABLE tree ADD COLUMN g AS (page + 1)",
  "ALTER TABLE boxes ADD COLUMN d DEFAULT (hex(zeroblob(100)))",
  "ALTER TABLE directory ADD COLUMN d DEFAULT (hex(zeroblob(100)))",
  "CREATE TABLE other (a UNIQUE, b CHECK (a > b)) STRICT",
  "CREATE TABLE textures (partition INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER NOT "
  "NULL)",
  "CREATE TABLE unused (part INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER NOT NULL)",
  "DROP TABLE boxes",
  "DROP TABLE directory",
  "PRAGMA user_version = 9",
  "PRAGMA user_version = 10",
  "PRAGMA user_version = 11",
  "PRAGMA user_version = 13",
  "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = rootpage + 1",
  "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'INTEGER', 'TEXT')",
  "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET type = 'view', rootpage = 0 WHERE name = "
  "'tree'",
  "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET name = 'pieces' WHERE name = 'tree'",
  "PRAGMA writable_schema = ON; INSERT INTO sqlite_schema SELECT * FROM sqlite_schema",
  "PRAGMA auto_vacuum = FULL; VACUUM",
  "PRAGMA page_size = 1024; VACUUM",
};

bool MutateSchema(sqlite3* database, std::uint64_t choice)
{
  sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  return sqlite3_exec(database, schemaChanges[choice % schemaChanges.size()], nullptr, nullptr,
           nullptr) == SQLITE_OK;
}

// Whether the file has the schema of a store as SQLite sees it.
bool HasSchemaOfStore(const std::filesystem::path& file)
{
  sqlite3* raw = nullptr;
  const Connection database(
    sqlite3_open_v2(file.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK ? raw
                                                                                    : nullptr);
  const auto version = Prepared(raw, "PRAGMA user_version");
  if (!version || sqlite3_step(version.get()) != SQLITE_ROW)
  {
    return false;
  }
  const auto tables = TablesOfStore(sqlite3_column_int(version.get(), 0));
  const auto rows = Prepared(raw, "SELECT type, name, tbl_name, sql FROM sqlite_schema");
  std::size_t same = 0;
  int status = rows ? sqlite3_step(rows.get()) : SQLITE_ERROR;
  for (; status == SQLITE_ROW; status = sqlite3_step(rows.get()))
  {
    const auto text = [&rows](int column)
    {
      const auto bytes = BlobOf(rows.get(), column);
      return std::string(bytes.begin(), bytes.end());
    };
    same += std::any_of(tables.begin(), tables.end(),
              [&text](const StoreTable& table)
              {
                return text(0) == "table" && text(1) == table.name && text(2) == table.name &&
                       text(3) == table.sql;
              })
              ? 1
              : 1000;
  }
  return status == SQLITE_DONE && same == tables.size();
}

void Read(const std::filesystem::path& file)
{
  const auto store = Store::Open(file);
  if (!store)
  {
    Require(!store.GetError().message.empty(), "an error without a message");
    return;
  }
  Require(HasSchemaOfStore(file), "a store with another schema");
  const bool whole = (*store)->Verify().empty();
  std::size_t read = 0;
  for (const PieceId id : (*store)->PieceIds())
  {
    const auto piece = (*store)->ReadPiece(id);
    Require(piece || !whole, "a whole store with a piece that cannot be read");
    if (++read > mostBlobs)
    {
      break;
    }
  }
  Mesh unused;
  Require(AddUnused(**store, unused).HasValue() || !whole,
    "a whole store with unused vertices that cannot be read");
}

// Returns the new size; 0 if the store has no row of the chosen kind.
std::size_t MutateRow(std::uint8_t* data, std::size_t size, std::size_t most, std::uint64_t choice)
{
  const auto database = Deserialized(data, size);
  const bool done =
    database && (choice % 7 == 0    ? MutateMetadata(database.get())
                  : choice % 7 == 1 ? MutatePiece(database.get(), choice / 7)
                  : choice % 7 == 2 ? MutateNode(database.get(), "tree", "page", choice / 7)
                  : choice % 7 == 3 ? MutateNode(database.get(), "boxes", "node", choice / 7)
                  : choice % 7 == 4 ? MutateNode(database.get(), "unused", "part", choice / 7)
                  : choice % 7 == 5 ? MutateContent(database.get(), choice / 7)
                                    : MutateSchema(database.get(), choice / 7));
  if (!done)
  {
    return 0;
  }
  sqlite3_int64 bytes = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> serialized(
    sqlite3_serialize(database.get(), "main", &bytes, 0), sqlite3_free);
  if (!serialized || static_cast<std::size_t>(bytes) > most)
  {
    return 0;
  }
  std::memcpy(data, serialized.get(), static_cast<std::size_t>(bytes));
  return static_cast<std::size_t>(bytes);
}

}

extern "C" std::size_t LLVMFuzzerCustomMutator(
  std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed)
{
  std::mt19937 random(seed);
  const bool raw = random() % 4 == 0;
  const auto mutated = raw ? 0 : MutateRow(data, size, most, random());
  return mutated != 0 ? mutated : LLVMFuzzerMutate(data, size, most);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  static const Folder folder;
  const auto file = folder.Path / "model.kds";
  std::ofstream(file, std::ios::binary)
    .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  StoreCatalog catalog(
    folder.Path, [](const std::filesystem::path&, const std::string&) {}, std::chrono::seconds(0),
    std::size_t{ 1 } << 20);
  Require(catalog.Reload().HasValue(), "the folder cannot be read");
  for (const auto& model : catalog.Models())
  {
    Serve(*model);
  }
  Read(file);
  return 0;
}
