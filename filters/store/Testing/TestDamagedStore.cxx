// SPDX-License-Identifier: BSD-3-Clause
// Store: what is damaged is named, and the rest is read; a file that is written to while it is open
// is read no more.
#include "Testing/Fixtures/Meshes.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <optional>
#include <random>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class DamagedStore : public StoreTest
{
};

void Sql(const fs::path& file, const std::string& statement)
{
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, statement.c_str(), nullptr, nullptr, &message), SQLITE_OK)
    << message;
  sqlite3_close(database);
}

// The bytes of `from` take the place of those of `to`, in the same file, as by cp.
void OverwriteInPlace(const fs::path& from, const fs::path& to)
{
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary); // truncates
  out << in.rdbuf();
}

}

// Its checksum is right, and its length that of its characters.
TEST_F(DamagedStore, ATextIsNoBlob)
{
  this->Build(Torus(24, 12), {});
  Sql(this->File(), "UPDATE tree SET data = CAST(data AS TEXT) WHERE page = 1");
  Sql(this->File(), "UPDATE boxes SET data = CAST(data AS TEXT) WHERE node = 1");
  Sql(this->File(), "UPDATE pieces SET data = CAST(data AS TEXT) WHERE id = 1");
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  const PieceId piece{ Resolution::Level(0), 1 };
  const auto missing = [](const auto& result, const std::string& name)
  {
    ASSERT_FALSE(result) << name;
    EXPECT_EQ(result.GetError().code, ErrorCode::Damaged);
    EXPECT_EQ(result.GetError().message, name + ": row is missing");
  };
  missing((*store)->Read(protocol::BlobId::TreePage(1)), "tree/1");
  missing((*store)->Size(protocol::BlobId::TreePage(1)), "tree/1");
  missing((*store)->Read(protocol::BlobId::PartitionBoxes(1)), "boxes/1");
  missing((*store)->Size(protocol::BlobId::PartitionBoxes(1)), "boxes/1");
  missing((*store)->Read(BlobOfPiece(piece, (*store)->Info().depths)), "levels/0/1");
  missing((*store)->Size(BlobOfPiece(piece, (*store)->Info().depths)), "levels/0/1");
}

TEST_F(DamagedStore, EveryRowThatIsDamagedIsNamed)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  const Mesh mesh = Torus(96, 48);
  const auto damageOf = [&](const std::string& statement)
  {
    this->Build(mesh, options);
    Sql(this->File(), statement);
    std::vector<std::string> messages;
    const auto store = Store::Open(this->File());
    if (!store)
    {
      return std::vector<std::string>{ store.GetError().message };
    }
    for (const Error& error : (*store)->Verify())
    {
      messages.push_back(error.message);
    }
    return messages;
  };
  using Messages = std::vector<std::string>;
  const std::string last = std::to_string((std::int64_t{ 63 } << 32) | (32 + 5));
  EXPECT_EQ(damageOf("UPDATE pieces SET data = zeroblob(length(data)) WHERE id = " + last),
    Messages{ "partitions/5: wrong checksum" });
  EXPECT_EQ(
    damageOf("DELETE FROM pieces WHERE id = " + last), Messages{ "partitions/5: row is missing" });
  EXPECT_EQ(damageOf("UPDATE pieces SET vertices = vertices + 1 WHERE resolution = 3"),
    Messages{ "levels/3/1: wrong checksum" });
  EXPECT_EQ(damageOf("UPDATE pieces SET node = 2 WHERE resolution = 3"),
    Messages{ "levels/3/1: its row: resolution is 3, node 2" });
  EXPECT_EQ(damageOf("UPDATE pieces SET resolution = 'x' WHERE id = " + last),
    Messages{ "partitions/5: its row: resolution is 'x', node 37" });
  EXPECT_EQ(damageOf("INSERT INTO pieces VALUES (-7, 1, 1, 0, 0, x'', 0)"),
    Messages{ "pieces/-7: its row: resolution is 1, node 1" });
  EXPECT_EQ(
    damageOf("UPDATE tree SET checksum = checksum + 1"), Messages{ "tree/1: wrong checksum" });
  EXPECT_EQ(
    damageOf("UPDATE boxes SET checksum = checksum + 1"), Messages{ "boxes/1: wrong checksum" });
  EXPECT_EQ(damageOf("UPDATE metadata SET value = replace(value, 'mesh.ply', 'MESH.ply')"),
    Messages{ "metadata: row \"model\" has a wrong checksum" });
  EXPECT_EQ(damageOf("DELETE FROM metadata"), Messages{ "metadata: row \"model\" is missing" });
  EXPECT_EQ(damageOf("PRAGMA user_version = 99"),
    Messages{ "store version 99; this program reads versions 9 to 12: build the store again" });
  EXPECT_EQ(damageOf("PRAGMA application_id = 5"), Messages{ "not a KdStream store" });
}

TEST_F(DamagedStore, FlippedBytesAreNoticedAndTheRestIsRead)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  std::ifstream file(this->File(), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  const auto healthy = *Store::Open(this->File());
  std::map<PieceId, std::vector<std::uint8_t>> blobs;
  for (const PieceId id : healthy->PieceIds())
  {
    blobs[id] = *healthy->Read(BlobOfPiece(id, healthy->Info().depths));
  }
  std::mt19937 random(17);
  unsigned noticed = 0, unopened = 0;
  constexpr unsigned flips = 150;
  for (unsigned i = 0; i < flips; ++i)
  {
    std::string damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
    std::ofstream(this->File("damaged.kds"), std::ios::binary | std::ios::trunc) << damaged;
    const auto store = Store::Open(this->File("damaged.kds"));
    if (!store)
    {
      EXPECT_FALSE(store.GetError().message.empty());
      ++unopened;
      continue;
    }
    const bool whole_ = (*store)->Verify().empty();
    noticed += !whole_;
    for (const auto& [id, blob] : blobs)
    {
      const auto read = (*store)->Read(BlobOfPiece(id, (*store)->Info().depths));
      if (read)
      {
        ASSERT_EQ(*read, blob) << "a wrong blob passed for whole";
      }
      else
      {
        ASSERT_FALSE(whole_) << "verify says whole, but a blob is not";
        ASSERT_EQ(read.GetError().code, ErrorCode::Damaged);
      }
    }
  }
  // Most of the file is live data; the rest is free space between rows, a good part where the rows
  // are as small as here.
  EXPECT_GT(noticed + unopened, flips * 6 / 10);
  EXPECT_LT(unopened, flips / 4) << "a flip must rarely cost the whole store";
}

TEST_F(DamagedStore, ARenameOverTheFileLeavesReadersOnTheOldOne)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const auto store = *Store::Open(this->File());
  const auto unread = *Store::Open(this->File()); // has no connection yet
  const PieceId id{ Resolution::Original(), 32 };
  const auto before = store->Read(BlobOfPiece(id, store->Info().depths));
  ASSERT_TRUE(before);
  this->Build(Torus(97, 48), options);
  // One connection is open on the old file, others are still to be opened.
  std::atomic<unsigned> wrong{ 0 };
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 8; ++t)
  {
    threads.emplace_back(
      [&]()
      {
        for (unsigned i = 0; i < 50; ++i)
        {
          const auto blob = store->Read(BlobOfPiece(id, store->Info().depths));
          wrong += !blob || *blob != *before;
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0U);
  const auto late = unread->Read(BlobOfPiece(id, unread->Info().depths));
  ASSERT_TRUE(late) << late.GetError().message;
  EXPECT_EQ(*late, *before);
  fs::remove(this->File());
  EXPECT_EQ(*unread->Read(BlobOfPiece(id, unread->Info().depths)), *before);
  this->Build(Torus(97, 48), options);
  const auto fresh = Store::Open(this->File());
  ASSERT_TRUE(fresh);
  EXPECT_NE(*(*fresh)->Read(BlobOfPiece(id, (*fresh)->Info().depths)), *before);
}

TEST_F(DamagedStore, AFileThatIsOverwrittenIsReadNoMore)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const PieceId id{ Resolution::Original(), 32 };
  const fs::path other = this->File("other.kds"), kept = this->File("kept.kds");
  ASSERT_TRUE(BuildStore(Torus(97, 48), "torus.ply", other, options));
  fs::copy(this->File(), kept);
  const std::uintmax_t size = std::max(fs::file_size(this->File()), fs::file_size(other));
  fs::resize_file(this->File(), size);
  fs::resize_file(other, size);
  const auto store = *Store::Open(this->File());
  ASSERT_TRUE(store->Read(BlobOfPiece(id, store->Info().depths)));
  const auto read = [&store](PieceId piece)
  {
    const auto blob = store->Read(BlobOfPiece(piece, store->Info().depths));
    return blob ? std::optional<ErrorCode>() : blob.GetError().code;
  };

  // Its name, links and permissions are not its content.
  fs::permissions(this->File(), fs::perms::owner_all);
  fs::rename(this->File(), this->File("moved.kds"));
  fs::create_hard_link(this->File("moved.kds"), this->File());
  EXPECT_EQ(read(id), std::nullopt);

  // Another store of the same size, which says that it is as old.
  const auto written = fs::last_write_time(this->File());
  OverwriteInPlace(other, this->File());
  fs::last_write_time(this->File(), written);
  EXPECT_EQ(read({ Resolution::Original(), 33 }), ErrorCode::Changed);
  EXPECT_EQ(read(id), ErrorCode::Changed);
  OverwriteInPlace(kept, this->File());
  EXPECT_EQ(read(id), ErrorCode::Changed) << "once changed is changed for ever";
}

// The tree of one of depth 30 would take 103 GB.
TEST_F(DamagedStore, ATinyStoreThatClaimsALotIsRefused)
{
  this->Build(Torus(12, 6), {});
  ModelDescription info = (*Store::Open(this->File()))->Info();
  info.partitioner = "octree";
  info.levels.clear();
  for (const unsigned depth : { 14U, 22U, 30U })
  {
    info.depths = { depth, depth, depth };
    info.partitions = std::uint64_t{ 1 } << depth;
    const std::string json = MetadataOf(info);
    Sql(this->File(), "UPDATE metadata SET value = '" + json + "', checksum = " +
                        std::to_string(MetadataChecksum("model", json)) + " WHERE key = 'model'");
    const auto store = Store::Open(this->File());
    ASSERT_FALSE(store);
    EXPECT_EQ(store.GetError().code, ErrorCode::Damaged);
    EXPECT_NE(store.GetError().message.find("partitions of depth " + std::to_string(depth)),
      std::string::npos)
      << store.GetError().message;
  }
  // Nor does it get so much where it looks large enough, with a hole at its end.
  fs::resize_file(this->File(), std::uintmax_t{ 31 } << 30);
  const auto hollow = Store::Open(this->File());
  ASSERT_TRUE(hollow) << hollow.GetError().message;
  const auto boxes = (*hollow)->ReadBoxes();
  ASSERT_FALSE(boxes);
  EXPECT_EQ(boxes.GetError().code, ErrorCode::Damaged);
  const auto damage = (*hollow)->Verify();
  ASSERT_FALSE(damage.empty());
  EXPECT_LT(damage.size(), 2000u);
  EXPECT_EQ(damage.back().message, "there is more, which is not checked");
}

TEST_F(DamagedStore, AFileThatIsTruncatedIsReadNoMore)
{
  this->Build(Torus(96, 48), {});
  const auto store = *Store::Open(this->File());
  fs::resize_file(this->File(), fs::file_size(this->File()) / 2);
  for (const PieceId id : store->PieceIds())
  {
    const auto blob = store->Read(BlobOfPiece(id, store->Info().depths));
    ASSERT_FALSE(blob);
    EXPECT_EQ(blob.GetError().code, ErrorCode::Changed) << blob.GetError().message;
  }
}
