// SPDX-License-Identifier: BSD-3-Clause
// Stores of versions before 13, written by earlier builds: they are read as before, and their
// damage is reported as before.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <map>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class KeptVersions : public StoreTest
{
protected:
  // Makes the store: a copy of the kept one of this version, changed by these statements.
  void Make(int version, const std::string& statements = "")
  {
    const fs::path kept =
      fs::path(KDSTREAM_KEPT_STORES) / ("version-" + std::to_string(version) + ".kds");
    fs::copy_file(kept, this->File(), fs::copy_options::overwrite_existing);
    Sql(this->File(), statements);
  }

  // What Verify reports, or why the store cannot be opened.
  std::vector<std::string> DamageOf(int version, const std::string& statements)
  {
    this->Make(version, statements);
    const auto store = Store::Open(this->File());
    std::vector<std::string> messages;
    for (const Error& error : store ? (*store)->Verify() : std::vector<Error>{ store.GetError() })
    {
      messages.push_back(error.message);
    }
    return messages;
  }
};

using Messages = std::vector<std::string>;

}

TEST_F(KeptVersions, AreWholeAndTheirMeshIsThere)
{
  const std::map<int, std::string> digests{ { 9, "915d50dc2b23a6ef6674ebac3194f1bb" },
    { 10, "11a0d3e5cceda2192d86f2649b5b073f" }, { 11, "57c3654edbb1fcf7057bc7caa53271b5" },
    { 12, "b145a47da198bf919f4169b6e4e77197" } };
  for (const auto& [version, digest] : digests)
  {
    SCOPED_TRACE(version);
    this->Make(version);
    const auto opened = Store::Open(this->File());
    ASSERT_TRUE(opened) << opened.GetError().message;
    const Store& store = **opened;
    const ModelDescription& model = store.Info();
    EXPECT_EQ(model.digest, digest);
    EXPECT_EQ(model.textures.has_value(), version == 10 || version == 12);
    EXPECT_EQ(model.unused.has_value(), version == 11 || version == 12);
    EXPECT_EQ(model.title, version == 9 ? "A sheet" : "");
    EXPECT_EQ(store.Verify().size(), 0U);
    for (const std::string& name : NamesOfBlobs(store))
    {
      if (const auto id = protocol::ParseBlobName(name))
      {
        const auto blob = store.Read(*id);
        ASSERT_TRUE(blob) << blob.GetError().message;
        EXPECT_EQ(store.Size(*id).Value(), blob->size()) << name;
      }
    }
    std::vector<std::uint32_t> partitions(model.partitions);
    for (std::uint32_t i = 0; i < partitions.size(); ++i)
    {
      partitions[i] = i;
    }
    const auto mesh = GlueStoreMesh(store, partitions);
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->points.size(), model.vertices);
    EXPECT_EQ(mesh->triangles.size(), model.triangles);
  }
}

TEST_F(KeptVersions, EveryRowThatIsDamagedIsNamed)
{
  EXPECT_EQ(this->DamageOf(9, ""), Messages{});
  const std::string last = std::to_string((std::int64_t{ 63 } << 32) | (8 + 5));
  EXPECT_EQ(this->DamageOf(9, "UPDATE pieces SET data = zeroblob(length(data)) WHERE id = " + last),
    Messages{ "partitions/5: wrong checksum" });
  EXPECT_EQ(this->DamageOf(9, "DELETE FROM pieces WHERE id = " + last),
    Messages{ "partitions/5: row is missing" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE pieces SET data = CAST(data AS TEXT) WHERE id = " + last),
    Messages{ "partitions/5: row is missing" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE pieces SET vertices = vertices + 1 WHERE resolution = 3"),
    Messages{ "levels/3/1: wrong checksum" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE pieces SET node = 2 WHERE resolution = 3"),
    Messages{ "levels/3/1: its row: resolution is 3, node 2" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE pieces SET resolution = 'x' WHERE id = " + last),
    Messages{ "partitions/5: its row: resolution is 'x', node 13" });
  EXPECT_EQ(this->DamageOf(9, "INSERT INTO pieces VALUES (-7, 1, 1, 0, 0, x'', 0)"),
    Messages{ "pieces/-7: its row: resolution is 1, node 1" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE tree SET checksum = checksum + 1"),
    Messages{ "tree/1: wrong checksum" });
  EXPECT_EQ(this->DamageOf(9, "UPDATE boxes SET checksum = checksum + 1"),
    Messages{ "boxes/1: wrong checksum" });
  EXPECT_EQ(this->DamageOf(10, "DELETE FROM textures"), Messages{ "textures/0: row is missing" });
  EXPECT_EQ(this->DamageOf(11, "UPDATE unused SET data = zeroblob(length(data))"),
    Messages{ "unused/0: wrong checksum" });
}

TEST_F(KeptVersions, AnotherSchemaIsRefusedAndNamed)
{
  const auto refused = [&](int version, const std::string& statements, const std::string& why)
  { EXPECT_EQ(this->DamageOf(version, statements), Messages{ "not a KdStream store: " + why }); };
  refused(9, "CREATE INDEX i ON pieces(abs(node)) WHERE node > 3", "it has an index 'i'");
  refused(9, "CREATE TABLE content (part INTEGER PRIMARY KEY, data BLOB NOT NULL)",
    "it has a table 'content'");
  refused(9, "ALTER TABLE boxes ADD COLUMN more", "its table 'boxes' differs from that of a store");
  refused(9, "PRAGMA page_size = 1024; VACUUM", "its page size is not that of a store, 4096 bytes");
  refused(10, "PRAGMA user_version = 9", "it has a table 'textures'");
  refused(11, "PRAGMA user_version = 13; PRAGMA page_size = 1024; VACUUM",
    "its table 'metadata' differs from that of a store");
  for (const auto& [version, table] : { std::pair{ 10, "textures" }, { 11, "unused" } })
  {
    const std::string name = table, is = "PRAGMA user_version = " + std::to_string(version) + ";";
    EXPECT_EQ(this->DamageOf(9, is),
      Messages{ "its tables are not those of a store: '" + name + "' is missing" });
    EXPECT_EQ(this->DamageOf(9, is + std::string(TablesOfStore(version).back().sql)),
      Messages{ "metadata: its " + (name == "unused" ? std::string("unused vertices") : name) +
                " do not fit the store's version" });
  }
}

TEST_F(KeptVersions, AreReadAndNotChanged)
{
  this->Make(9);
  const auto edited = EditStore(this->File(), { .title = "Another" });
  ASSERT_FALSE(edited);
  EXPECT_TRUE(FailsAt(edited, ErrorCode::Unsupported));
  EXPECT_EQ(this->FilesInFolder(), 1U);
}
