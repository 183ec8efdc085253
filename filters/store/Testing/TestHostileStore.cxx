// SPDX-License-Identifier: BSD-3-Clause
// Hostile stores: whatever their schema and pages contain, SQLite's work always ends, and the error
// says what is wrong.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/store/StoreConnection.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

// The good store has about 40 partitions.
class HostileStore : public StoreTest
{
protected:
  void SetUp() override
  {
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    this->Build(Torus(96, 48), options);
    fs::rename(this->File(), this->File("good"));
  }

  // Makes the store: the good one, changed by these statements.
  void Make(const std::string& statements)
  {
    fs::copy_file(this->File("good"), this->File(), fs::copy_options::overwrite_existing);
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(this->File().c_str(), &database), SQLITE_OK);
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);
    EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << statements << ": " << sqlite3_errmsg(database);
    EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
  }

  void Write(const std::string& bytes) const
  {
    std::ofstream(this->File(), std::ios::binary | std::ios::trunc) << bytes;
  }

  // Why the store cannot be opened; "" if it can.
  std::string Refusal() const
  {
    const auto store = Store::Open(this->File());
    return store ? "" : store.GetError().message;
  }

  // Replaces the metadata by this text, with the right checksum.
  void MakeMetadata(const std::string& json) { this->Make(PutMetadata(json)); }
};

// A number in a page, the highest byte first.
std::uint32_t NumberAt(const std::string& bytes, std::size_t at, std::size_t size)
{
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size; ++i)
  {
    number = number << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  }
  return number;
}

void SetNumber(std::string& bytes, std::size_t at, std::size_t size, std::size_t number)
{
  for (std::size_t i = 0; i < size; ++i)
  {
    bytes[at + i] = static_cast<char>(number >> (8 * (size - 1 - i)));
  }
}

// A recursive count that never ends.
const std::string endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) "
                            "SELECT count(*) FROM c";

constexpr const char* notAStore = "not a KdStream store: ";

}

TEST_F(HostileStore, TheGoodOneIsRead)
{
  this->Make("");
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  EXPECT_TRUE((*store)->Verify().empty());
}

TEST_F(HostileStore, AnotherSchemaIsRefusedAndNamed)
{
  const std::vector<std::pair<std::string, std::string>> schemas{
    // Views, one of which never ends.
    { "ALTER TABLE metadata RENAME TO m; CREATE VIEW metadata AS SELECT 'model' AS key, value, "
      "checksum FROM m, (" +
        endless + ")",
      "view 'metadata'" },
    { "DROP TABLE metadata; CREATE VIEW metadata AS SELECT 'model' AS key, (" + endless +
        ") AS value, 0 AS checksum",
      "view 'metadata'" },
    { "CREATE VIEW harmless AS SELECT 1", "view 'harmless'" },
    { "CREATE VIEW \"\x1B[2J\n\" AS SELECT 1", "view '?[2J?'" },
    // Triggers, which would run when the store is edited.
    { "CREATE TRIGGER t BEFORE UPDATE ON metadata BEGIN SELECT (" + endless + "); END",
      "trigger 't'" },
    // Indexes, with and without an expression, and one on a table that a store does not have.
    { "CREATE INDEX i ON content(part)", "index 'i'" },
    { "CREATE INDEX i ON content(abs(part)) WHERE part > 3", "index 'i'" },
    { "CREATE TABLE other (a UNIQUE)", "index 'sqlite_autoindex_other_1'" },
    { "CREATE TABLE other (a)", "table 'other'" },
    // Columns that are computed, checked or additional.
    { "ALTER TABLE directory ADD COLUMN g AS (hex(zeroblob(10000)))", "table 'directory' differs" },
    { "DROP TABLE content; CREATE TABLE content (part INTEGER PRIMARY KEY, data BLOB NOT NULL "
      "DEFAULT (abs(-3)))",
      "table 'content' differs" },
    { "ALTER TABLE content ADD COLUMN more", "table 'content' differs" },
    { "DROP TABLE directory; CREATE TABLE directory (part INTEGER PRIMARY KEY, data BLOB NOT NULL "
      "CHECK (length(hex(zeroblob(1000000))) > 0))",
      "table 'directory' differs" },
    { "DROP TABLE directory; CREATE TABLE directory (part INTEGER PRIMARY KEY, data BLOB NOT NULL) "
      "STRICT",
      "table 'directory' differs" },
    { "DROP TABLE content; CREATE TABLE content (part INTEGER PRIMARY KEY, data BLOB NOT NULL) "
      "WITHOUT ROWID",
      "table 'content' differs" },
    { "CREATE VIRTUAL TABLE v USING fts5(a)", "virtual table 'v'" },
    { "CREATE TABLE textures (partition INTEGER PRIMARY KEY, data BLOB NOT NULL, checksum INTEGER "
      "NOT NULL)",
      "table 'textures'" }, // of an earlier version
    { "ANALYZE", "table 'sqlite_stat1'" },
    // Texts, rows and numbers that do not belong in a schema.
    { "PRAGMA writable_schema = ON; INSERT INTO sqlite_schema VALUES ('table', 'content', "
      "'content', 3, 'CREATE TABLE content (a)')",
      "table 'content' differs" },
    { "PRAGMA writable_schema = ON; INSERT INTO sqlite_schema SELECT * FROM sqlite_schema",
      "its table 'metadata' appears twice" },
    { "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM "
      "sqlite_schema WHERE name = 'directory') WHERE name = 'content'",
      "its table 'content' appears twice" },
    { "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET type = 'thing' WHERE name = 'content'",
      "other objects" },
    { "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET tbl_name = 'directory' WHERE name = "
      "'content'",
      "table 'content' differs" },
    { "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = CAST(sql AS BLOB) WHERE name = "
      "'content'",
      "table 'content' differs" },
    { "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = -3 WHERE name = 'content'",
      "virtual table 'content'" },
    // A statement longer than a page.
    { "CREATE TABLE huge (a /* " + std::string(196950, 'x') + " */)", "table 'huge'" },
    // Properties of the file.
    { "PRAGMA page_size = 512; VACUUM", "page size" },
    { "PRAGMA page_size = 65536; VACUUM", "page size" },
    { "PRAGMA journal_mode = WAL", "write-ahead log" },
    { "PRAGMA auto_vacuum = FULL; VACUUM", "auto-vacuum" },
  };
  for (const auto& [statements, why] : schemas)
  {
    SCOPED_TRACE(statements.substr(0, 200));
    this->Make(statements);
    const auto store = Store::Open(this->File());
    EXPECT_TRUE(fixtures::FailsAt(store, ErrorCode::InvalidInput, why));
    const auto edited = EditStore(this->File(), { .title = "Another" });
    EXPECT_TRUE(fixtures::FailsAt(edited, ErrorCode::InvalidInput, why));
  }
}

TEST_F(HostileStore, ThousandsOfTablesAreNotRead)
{
  std::string tables = "BEGIN;";
  for (int i = 0; i < 3000; ++i)
  {
    tables += "CREATE TABLE t" + std::to_string(i) + " (a, b, c);";
  }
  this->Make(tables + "COMMIT");
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { notAStore, "other tables" }));
}

TEST_F(HostileStore, TextsInUtf16AreRefused)
{
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(this->File().c_str(), &database), SQLITE_OK);
  const std::string make =
    "PRAGMA encoding = 'UTF-16le'; PRAGMA page_size = " + std::to_string(storePageBytes) +
    "; PRAGMA application_id = " + std::to_string(storeApplicationId) +
    "; PRAGMA user_version = " + std::to_string(storeVersion) + ";" + SchemaOfStore(storeVersion);
  ASSERT_EQ(sqlite3_exec(database, make.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  ASSERT_EQ(sqlite3_close(database), SQLITE_OK);
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { notAStore, "encoding" }));
}

TEST_F(HostileStore, ATableThatIsMissingIsNamed)
{
  for (const StoreTable& table : TablesOfStore(storeVersion))
  {
    this->Make("DROP TABLE " + std::string(table.name));
    EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { "'" + std::string(table.name) + "'" }));
  }
}

// If any byte of the header or of the schema is changed, the store is refused or read as before.
TEST_F(HostileStore, AnyByteOfTheFirstPageMayBeAnotherOne)
{
  const std::string good = this->Bytes("good");
  this->Write(good);
  const int file = ::open(this->File().c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(file, 0);
  const auto model = ReadStoredModel(file);
  ASSERT_TRUE(model) << model.GetError().message;
  const std::size_t content = NumberAt(good, 105, 2); // where the rows of the schema begin
  for (std::size_t i = 0; i < storePageBytes; i += i == 119 ? content - i : 1)
  {
    for (const int byte : { 0, 0x81, 0xFF })
    {
      const char put = static_cast<char>(byte);
      ASSERT_EQ(::pwrite(file, &put, 1, static_cast<off_t>(i)), 1);
      const auto read = ReadStoredModel(file);
      EXPECT_TRUE(read ? *read == *model : !read.GetError().message.empty()) << i;
    }
    ASSERT_EQ(::pwrite(file, &good[i], 1, static_cast<off_t>(i)), 1);
  }
  ::close(file);
}

TEST_F(HostileStore, ShortFilesAreRefused)
{
  const std::string good = this->Bytes("good");
  for (const std::size_t size : { 0, 15, 16, 99, 100, 108, 512, 1023, 1024, 1025, 2047 })
  {
    this->Write(good.substr(0, size));
    EXPECT_NE(this->Refusal(), "") << size;
  }
}

TEST_F(HostileStore, MetadataThatAreTooMuchAreRefused)
{
  std::string json = "[0";
  while (json.size() < 30'000'000)
  {
    json += ",0";
  }
  this->MakeMetadata(json + "]");
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { "metadata: ", "too large" }));
  this->Make("INSERT INTO metadata VALUES ('other', '', 0)");
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { "metadata: ", "more than one row" }));
  this->Make("UPDATE metadata SET key = hex(zeroblob(5000000))");
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { "metadata: ", "too large" }));
  this->Make("UPDATE metadata SET key = 'other'");
  EXPECT_EQ(this->Refusal(), "metadata: row \"model\" is missing");
  this->Make("UPDATE metadata SET value = CAST(value AS BLOB), checksum = zeroblob(5000000)");
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(), { "metadata: ", "too large" }));
}

// A store of an earlier version, whose rows verify reads in order. The table of pieces becomes a
// tree of 400^6 leaves: each page leads 400 times to the next.
TEST_F(HostileStore, ATreeWithoutAnEndIsEnded)
{
  fs::copy_file(fs::path(KDSTREAM_KEPT_STORES) / "version-9.kds", this->File());
  constexpr std::size_t pageBytes = mostStorePageBytes;
  std::string bytes = this->Bytes("model.kds");
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(this->File().c_str(), &database), SQLITE_OK);
  std::size_t root = 0;
  ASSERT_EQ(sqlite3_exec(
              database, "SELECT rootpage FROM sqlite_schema WHERE name = 'pieces'",
              [](void* to, int, char** values, char**)
              {
                *static_cast<std::size_t*>(to) = std::stoul(values[0]);
                return 0;
              },
              &root, nullptr),
    SQLITE_OK);
  sqlite3_close(database);
  ASSERT_EQ(bytes[(root - 1) * pageBytes], 13) << "it is a leaf";
  bytes += bytes.substr((root - 1) * pageBytes, pageBytes);
  const std::size_t leaf = bytes.size() / pageBytes;
  constexpr std::size_t depth = 6, children = 400;
  std::size_t next = bytes.size() / pageBytes;
  bytes.resize(bytes.size() + (depth - 1) * pageBytes);
  std::size_t page = root;
  for (std::size_t i = 0; i < depth; ++i)
  {
    const std::size_t child = i + 1 < depth ? ++next : leaf;
    const std::size_t at = (page - 1) * pageBytes;
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), pageBytes, '\0');
    bytes[at] = 5; // an inner page of a table
    SetNumber(bytes, at + 3, 2, children);
    SetNumber(bytes, at + 5, 2, pageBytes - children * 6);
    SetNumber(bytes, at + 8, 4, child);
    for (std::size_t cell = 0; cell < children; ++cell)
    {
      const std::size_t place = pageBytes - (cell + 1) * 6;
      SetNumber(bytes, at + 12 + 2 * cell, 2, place);
      SetNumber(bytes, at + place, 4, child);
      bytes[at + place + 4] = 1; // the key
    }
    page = child;
  }
  SetNumber(bytes, 28, 4, bytes.size() / pageBytes);
  this->Write(bytes);
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  const auto damage = (*store)->Verify();
  ASSERT_FALSE(damage.empty());
  EXPECT_TRUE(fixtures::IsAt(damage.front(), ErrorCode::Damaged, "pieces"));
}

// Files beside the store do not belong to it: they are neither read nor removed.
TEST_F(HostileStore, AJournalBesideTheStoreIsNotTouched)
{
  this->Make("");
  const std::string garbage(100000, '\x5A');
  for (const char* ending : { "-journal", "-wal", "-shm" })
  {
    std::ofstream(this->File("model.kds") += ending) << garbage;
  }
  ASSERT_EQ(this->Refusal(), "");
  ASSERT_TRUE(EditStore(this->File(), { .title = "Another" }));
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store);
  EXPECT_EQ((*store)->Info().title, "Another");
  EXPECT_TRUE((*store)->Verify().empty());
  for (const char* ending : { "-journal", "-wal", "-shm" })
  {
    EXPECT_EQ(this->Bytes(std::string("model.kds") + ending), garbage);
  }
  EXPECT_EQ(this->FilesInFolder(), 5u) << "the good one, the store, and what lies beside it";
}

// A list of free pages that forms a ring, and pages that are both free and used: an edit must end.
TEST_F(HostileStore, FreePagesThatAreARingAreSurvived)
{
  this->Make("DELETE FROM content WHERE part > 1");
  const std::string bytes = this->Bytes("model.kds");
  const std::size_t trunk = NumberAt(bytes, 32, 4);
  ASSERT_NE(trunk, 0u);
  for (const std::size_t next : { trunk, std::size_t{ 1 }, std::size_t{ 2 }, bytes.size() })
  {
    std::string hostile = bytes;
    SetNumber(hostile, (trunk - 1) * storePageBytes, 4, next);
    SetNumber(hostile, (trunk - 1) * storePageBytes + 4, 4, 0);
    SetNumber(hostile, 36, 4, 1000000);
    this->Write(hostile);
    const auto edited = EditStore(this->File(), { .description = std::string(4000, 'x') });
    EXPECT_TRUE(edited || !edited.GetError().message.empty());
  }
}
