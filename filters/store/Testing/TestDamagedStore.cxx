// SPDX-License-Identifier: BSD-3-Clause
// Store: damaged parts are reported by name, and all others can be read. Once a file is written to
// while it is open, every read fails.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

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

// Overwrites the bytes of `to` by those of `from`, in the same file, as cp does.
void OverwriteInPlace(const fs::path& from, const fs::path& to)
{
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary); // truncates
  out << in.rdbuf();
}

}

// The texts have the right bytes, and as many characters as bytes.
TEST_F(DamagedStore, ATextIsNotABlob)
{
  const std::vector<std::string> names{ "tree/1", "boxes/1", "levels/0/1" };
  for (const std::string table : { "directory", "content" })
  {
    this->Build(Torus(24, 12), {});
    Sql(this->File(), "UPDATE " + table + " SET data = CAST(data AS TEXT)");
    const auto store = Store::Open(this->File());
    ASSERT_TRUE(store) << store.GetError().message;
    for (const std::string& name : names)
    {
      const protocol::BlobId id = *protocol::ParseBlobName(name);
      const auto blob = (*store)->Read(id);
      EXPECT_TRUE(fixtures::FailsAt(blob, ErrorCode::Damaged, name));
      const auto size = (*store)->Size(id);
      EXPECT_EQ(size.HasValue(), table == "content");
      EXPECT_TRUE(size || fixtures::FailsAt(size, ErrorCode::Damaged, name));
    }
  }
}

TEST_F(DamagedStore, EveryBlobThatIsDamagedIsNamed)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 50;
  this->Build(Torus(96, 48), options);
  fs::rename(this->File(), this->File("good"));
  using Messages = std::vector<std::string>;
  const auto found = [&]
  {
    Messages messages;
    const auto store = Store::Open(this->File());
    for (const Error& error : store ? (*store)->Verify() : std::vector<Error>{ store.GetError() })
    {
      messages.push_back(error.message);
    }
    return messages;
  };
  const auto damageOf = [&](const std::string& statement)
  {
    fs::copy_file(this->File("good"), this->File(), fs::copy_options::overwrite_existing);
    Sql(this->File(), statement);
    return found();
  };
  const auto damageBy = [&](const std::function<void(StoreContent&)>& change)
  {
    fs::copy_file(this->File("good"), this->File(), fs::copy_options::overwrite_existing);
    StoreContent content(this->File());
    change(content);
    content.Write();
    return found();
  };
  for (const std::string name : { "levels/3/1", "partitions/5", "boxes/4", "tree/1" })
  {
    EXPECT_EQ(damageBy([&](StoreContent& content) { content.FirstByteOf(name) ^= 1; }),
      Messages{ name + ": wrong checksum" });
    EXPECT_EQ(damageBy([&](StoreContent& content) { ++content.PlaceOf(name).checksum; }),
      Messages{ name + ": wrong checksum" });
  }
  const auto names = StoreContent(this->File("good")).Names;
  const auto ofAll = [&](std::size_t first, std::size_t end, const std::string& what)
  {
    Messages all;
    for (std::size_t i = first; i < end; ++i)
    {
      all.push_back(names[i] + ": " + what);
    }
    return all;
  };
  ASSERT_GT(names.size(), 1 + blobsOfDirectoryRow);
  const std::size_t second = blobsOfDirectoryRow;
  EXPECT_EQ(damageOf("DELETE FROM directory WHERE part = 1"),
    ofAll(second, names.size(), "row is missing"));
  EXPECT_EQ(damageOf("UPDATE directory SET data = zeroblob(length(data)) WHERE part = 1"),
    ofAll(second, names.size(), "the directory is damaged"));
  EXPECT_EQ(damageOf("UPDATE directory SET data = (SELECT data FROM directory WHERE part = 0) "
                     "WHERE part = 1"),
    ofAll(second, names.size(), "the directory is damaged"))
    << "a row in the place of another one";
  EXPECT_EQ(
    damageOf("UPDATE content SET data = x'00' WHERE part = (SELECT max(part) FROM content)").back(),
    "tree/1: its row is too short");
  EXPECT_EQ(damageOf("DELETE FROM content WHERE part = (SELECT max(part) FROM content)").back(),
    "tree/1: row is missing");
  EXPECT_EQ(damageOf("UPDATE metadata SET value = replace(value, 'mesh.ply', 'MESH.ply')"),
    Messages{ "metadata: row \"model\" has a wrong checksum" });
  EXPECT_EQ(damageOf("DELETE FROM metadata"), Messages{ "metadata: row \"model\" is missing" });
  EXPECT_EQ(damageOf("PRAGMA user_version = 99"),
    Messages{ "store version 99; this program reads versions 9 to 15: a newer KdStream wrote it; "
              "update this one" });
  EXPECT_EQ(damageOf("PRAGMA user_version = 14"),
    Messages{ "metadata: its textures do not fit the store's version" });
  EXPECT_EQ(damageOf("PRAGMA user_version = 8"),
    Messages{ "store version 8; this program reads versions 9 to 15: build the store again" });
  EXPECT_EQ(damageOf("PRAGMA application_id = 5"), Messages{ "not a KdStream store" });
}

// A directory with right checksums, but with blobs that overlap or do not exist.
TEST_F(DamagedStore, ADirectoryThatLiesIsSurvived)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const auto messageOf = [&](const std::string& name, std::uint64_t begin, std::uint32_t bytes)
  {
    StoreContent content(this->File());
    BlobPlace& place = content.PlaceOf(name);
    const BlobPlace before = place;
    place.begin = begin;
    place.bytes = bytes;
    content.Write();
    const auto store = *Store::Open(this->File());
    const auto blob = store->Read(*protocol::ParseBlobName(name));
    EXPECT_FALSE(blob);
    place = before;
    content.Write();
    return blob ? "" : blob.GetError().message;
  };
  const std::uint64_t begin = 0; // where the content begins
  EXPECT_EQ(messageOf("levels/0/1", std::uint64_t{ 1 } << 61, 100), "levels/0/1: row is missing");
  EXPECT_EQ(
    messageOf("levels/0/1", ~std::uint64_t{ 0 }, 100), "levels/0/1: the directory is damaged");
  EXPECT_EQ(messageOf("levels/0/1", begin, 0), "levels/0/1: wrong checksum");
  EXPECT_EQ(
    messageOf("levels/0/1", begin, (64U << 20) + 1), "levels/0/1: the directory is damaged");
  EXPECT_EQ(messageOf("levels/0/1", begin, 64U << 20), "levels/0/1: its row is too short");
  // All blobs claim to be as long as the whole content.
  StoreContent content(this->File());
  for (std::size_t first = 0; first < content.Places.size(); ++first)
  {
    content.Places[first].bytes = static_cast<std::uint32_t>(content.Bytes.size());
  }
  content.Write();
  const std::vector<Error> found = (*Store::Open(this->File()))->Verify();
  EXPECT_EQ(found.size(), content.Places.size());
}

TEST_F(DamagedStore, FlippedBytesAreNoticedAndTheRestIsRead)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const std::string whole = this->Bytes();
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
  // Most of the file is live data; the rest is free space between rows: a considerable part if rows
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
  // One connection to the old file is open; others are opened later.
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

  // Name, links and permissions are not part of the content.
  fs::permissions(this->File(), fs::perms::owner_all);
  fs::rename(this->File(), this->File("moved.kds"));
  fs::create_hard_link(this->File("moved.kds"), this->File());
  EXPECT_EQ(read(id), std::nullopt);

  // Overwritten by another store of the same size, with the time of the first one.
  const auto written = fs::last_write_time(this->File());
  OverwriteInPlace(other, this->File());
  fs::last_write_time(this->File(), written);
  EXPECT_EQ(read({ Resolution::Original(), 33 }), ErrorCode::Changed);
  EXPECT_EQ(read(id), ErrorCode::Changed);
  OverwriteInPlace(kept, this->File());
  EXPECT_EQ(read(id), ErrorCode::Changed) << "once changed is changed for ever";
}

// The tree of a store of depth 30 would take 103 GB.
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
    Sql(this->File(), PutMetadata(WriteStoredModel(info)));
    const auto store = Store::Open(this->File());
    ASSERT_FALSE(store);
    EXPECT_EQ(store.GetError().code, ErrorCode::Damaged);
    EXPECT_NE(store.GetError().message.find("partitions of depth " + std::to_string(depth)),
      std::string::npos)
      << store.GetError().message;
  }
  // Nor is memory allocated in proportion to the file, if it is large only because of a hole at its
  // end.
  fs::resize_file(this->File(), std::uintmax_t{ 31 } << 30);
  const auto hollow = Store::Open(this->File());
  ASSERT_TRUE(hollow) << hollow.GetError().message;
  const auto boxes = (*hollow)->ReadBoxes();
  ASSERT_FALSE(boxes);
  EXPECT_EQ(boxes.GetError().code, ErrorCode::Damaged);
  const auto damage = (*hollow)->Verify();
  ASSERT_FALSE(damage.empty());
  EXPECT_LT(damage.size(), 2000u);
  EXPECT_TRUE(IsAt(damage.back(), ErrorCode::Damaged));
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
