// SPDX-License-Identifier: BSD-3-Clause
// Builder, StoreWriter and Store: what goes in comes out, what is damaged is named, nothing is left
// behind.
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/Builder.h"
#include "filters/core/Weld.h"
#include "filters/core/pieces/Glue.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/StoreWriter.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <random>
#include <set>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class StoreTest : public ::testing::Test
{
protected:
  StoreTest()
    : Folder(fs::temp_directory_path() / ("kdstream-store-test-" + std::to_string(::getpid())))
  {
    fs::create_directories(this->Folder);
  }
  ~StoreTest() override { fs::remove_all(this->Folder); }

  fs::path File(const std::string& name = "model.kds") const { return this->Folder / name; }

  BuildReport Build(const Mesh& mesh, const BuildOptions& options, const Execution& execution = {})
  {
    Result<BuildReport> report = BuildStore(mesh, "mesh.ply", this->File(), options, execution);
    EXPECT_TRUE(report) << report.GetError().message;
    return std::move(*report);
  }

  std::size_t FilesInFolder() const
  {
    return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(this->Folder), fs::directory_iterator()));
  }

  fs::path Folder;
};

BuildOptions Lossless(bool weld, std::uint32_t size = 200)
{
  BuildOptions options;
  options.tree.verticesPerPartition = size;
  options.bits = 0;
  options.weld = weld;
  return options;
}

Mesh GlueAll(const Store& store)
{
  std::vector<Piece> pieces;
  for (const PieceId id : store.PieceIds())
  {
    if (id.resolution.IsOriginal())
    {
      Result<Piece> piece = store.ReadPiece(id);
      EXPECT_TRUE(piece) << piece.GetError().message;
      pieces.push_back(std::move(*piece));
    }
  }
  return *GluePartitions(pieces, store.Info().grid.scalarType);
}

mode_t PermissionsOf(const fs::path& file)
{
  struct stat state = {};
  EXPECT_EQ(::lstat(file.c_str(), &state), 0);
  return state.st_mode & 0777;
}

void Sql(const fs::path& file, const std::string& statement)
{
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, statement.c_str(), nullptr, nullptr, &message), SQLITE_OK)
    << message;
  sqlite3_close(database);
}

}

TEST_F(StoreTest, LosslessWithoutWeldingGivesTheInputBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const BuildReport report = this->Build(named.mesh, Lossless(false));
    const auto store = *Store::Open(this->File());
    const Mesh all = GlueAll(*store);
    EXPECT_EQ(PointMultiset(all), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(all), TriangleMultiset(named.mesh));
    EXPECT_LE(report.info.largestPartition - report.info.smallestPartition, 1U);
    EXPECT_TRUE(store->Verify().empty());
  }
}

TEST_F(StoreTest, WithWeldingTheWeldedMeshComesBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const BuildReport report = this->Build(named.mesh, Lossless(true));
    Mesh welded = named.mesh;
    EXPECT_EQ(report.info.welded, WeldVertices(welded));
    const Mesh all = GlueAll(**Store::Open(this->File()));
    EXPECT_EQ(PointMultiset(all), PointMultiset(welded));
    EXPECT_EQ(TriangleMultiset(all), TriangleMultiset(welded));
  }
}

TEST_F(StoreTest, TheDigestDependsOnInputAndOptionsAlone)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    std::set<std::string> digests;
    for (const unsigned threads : { 1U, 2U, 8U, 2U })
    {
      digests.insert(this->Build(named.mesh, options, MakeTbbExecution(threads)).info.digest);
    }
    EXPECT_EQ(digests.size(), 1U);
  }
  const Mesh torus = Torus(60, 40);
  std::set<std::string> digests;
  for (unsigned i = 0; i < 7; ++i)
  {
    BuildOptions options;
    options.tree.verticesPerPartition = i == 1 ? 300 : 200;
    options.tree.cellVertices = i == 2 ? 1 : 8;
    options.levels.sheets = i != 3;
    options.levels.representative = i == 4 ? Representative::Mean : Representative::Quadric;
    options.bits = i == 5 ? 0 : i == 6 ? 16 : 20;
    digests.insert(this->Build(torus, options).info.digest);
  }
  EXPECT_EQ(digests.size(), 7U) << "an option changes nothing";
  BuildOptions titled;
  titled.title = "A title";
  EXPECT_EQ(this->Build(torus, titled).info.digest, this->Build(torus, {}).info.digest)
    << "the title is no content";
}

TEST_F(StoreTest, WhatTheStoreSaysIsTrue)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  options.title = "T";
  options.credit = "C";
  options.license = "L";
  options.unit = "mm";
  const Mesh mesh = Torus(96, 48);
  this->Build(mesh, options);
  const auto store = *Store::Open(this->File());
  const ModelDescription& info = store->Info();
  EXPECT_EQ(info.title + info.credit + info.license + info.unit + info.input, "TCLmmmesh.ply");
  EXPECT_EQ(info.vertices, mesh.points.size());
  EXPECT_EQ(info.triangles, mesh.triangles.size());
  EXPECT_EQ(info.original.triangles, mesh.triangles.size());
  EXPECT_EQ(info.box, BoxOfPoints(mesh.points));
  std::map<Resolution, ResolutionDescription> found;
  for (const PieceId id : store->PieceIds())
  {
    const Piece piece = *store->ReadPiece(id);
    ResolutionDescription& resolution = found[id.resolution];
    ++resolution.pieces;
    resolution.vertices += piece.ownVertices;
    resolution.bytes += store->ReadPieceBlob(id)->size();
    EXPECT_TRUE(piece.deviations.empty());
  }
  const auto boxes = store->ReadBoxes();
  ASSERT_TRUE(boxes);
  const auto pieces = store->ReadPieceTable(*boxes);
  ASSERT_TRUE(pieces);
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    const ResolutionDescription &level = info.levels[depth],
                                &expected = found[Resolution::Level(depth)];
    EXPECT_EQ(level.pieces, expected.pieces);
    EXPECT_EQ(level.vertices, expected.vertices);
    EXPECT_EQ(level.bytes, expected.bytes);
    EXPECT_LE(level.deviation99, level.deviation);
    float largest = 0;
    std::uint64_t bytes = 0;
    for (const PieceId id : store->PieceIds())
    {
      if (id.resolution == Resolution::Level(depth))
      {
        const PieceFacts& piece = pieces->At(id);
        EXPECT_LE(piece.most99, piece.most);
        largest = std::max(largest, piece.most);
        bytes += piece.bytes;
      }
    }
    EXPECT_GE(bytes, level.bytes);
    EXPECT_LE(double(bytes), 1.125 * double(level.bytes));
    EXPECT_GE(double(largest), level.deviation);
    EXPECT_LE(double(largest), 1.0626 * level.deviation); // rounded up
    EXPECT_EQ(level.spacing, depth == 0 ? 4096U : level.spacing);
    EXPECT_LE(level.spacing * info.grid.step / 2, level.deviation99 / 4);
  }
  EXPECT_EQ((*boxes)[1], info.box);
}

TEST_F(StoreTest, EveryRowThatIsDamagedIsNamed)
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
    Messages{ "store version 99; this program reads version 8: build the store again" });
  EXPECT_EQ(damageOf("PRAGMA application_id = 5"), Messages{ "not a KdStream store" });
}

TEST_F(StoreTest, FlippedBytesAreNoticedAndTheRestIsRead)
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
    blobs[id] = *healthy->ReadPieceBlob(id);
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
      const auto read = (*store)->ReadPieceBlob(id);
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

TEST_F(StoreTest, ManyThreadsReadAtOnce)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const auto store = *Store::Open(this->File());
  std::atomic<unsigned> bad{ 0 };
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 8; ++t)
  {
    threads.emplace_back(
      [&]()
      {
        for (const PieceId id : store->PieceIds())
        {
          bad += !store->ReadPiece(id);
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(bad, 0U);
}

TEST_F(StoreTest, ARenameOverTheFileLeavesReadersOnTheOldOne)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const auto store = *Store::Open(this->File());
  const auto unread = *Store::Open(this->File()); // has no connection yet
  const PieceId id{ Resolution::Original(), 32 };
  const auto before = store->ReadPieceBlob(id);
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
          const auto blob = store->ReadPieceBlob(id);
          wrong += !blob || *blob != *before;
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(wrong, 0U);
  const auto late = unread->ReadPieceBlob(id);
  ASSERT_TRUE(late) << late.GetError().message;
  EXPECT_EQ(*late, *before);
  fs::remove(this->File());
  EXPECT_EQ(*unread->ReadPieceBlob(id), *before);
  this->Build(Torus(97, 48), options);
  const auto fresh = Store::Open(this->File());
  ASSERT_TRUE(fresh);
  EXPECT_NE(*(*fresh)->ReadPieceBlob(id), *before);
}

// The bytes of `from` take the place of those of `to`, in the same file, as by cp.
void OverwriteInPlace(const fs::path& from, const fs::path& to)
{
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary); // truncates
  out << in.rdbuf();
}

TEST_F(StoreTest, AFileThatIsOverwrittenIsReadNoMore)
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
  ASSERT_TRUE(store->ReadPieceBlob(id));
  const auto read = [&store](PieceId piece)
  {
    const auto blob = store->ReadPieceBlob(piece);
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

TEST_F(StoreTest, ABlobThatNoServerSendsIsNotWritten)
{
  this->Build(Torus(12, 6), {});
  const auto whole = *Store::Open(this->File());
  auto writer = StoreWriter::Create(this->File("large.kds"), whole->Info());
  ASSERT_TRUE(writer);
  const PieceId id{ Resolution::Original(), NodeOfPartition(0, whole->Info().depths) };
  const Piece piece = *whole->ReadPiece(id);
  const std::vector<std::uint8_t> bytes(Store::largestBlobBytes + 1);
  const Status refused = (*writer)->AddPiece(piece, bytes);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_EQ(refused.GetError().message,
    "partitions/0 takes 67108865 bytes, more than the 64 MiB that servers send: make partitions of "
    "fewer vertices");
}

// The tree of one of depth 30 would take 103 GB.
TEST_F(StoreTest, ATinyStoreThatClaimsALotIsRefused)
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
}

TEST_F(StoreTest, AFileThatIsTruncatedIsReadNoMore)
{
  this->Build(Torus(96, 48), {});
  const auto store = *Store::Open(this->File());
  fs::resize_file(this->File(), fs::file_size(this->File()) / 2);
  for (const PieceId id : store->PieceIds())
  {
    const auto blob = store->ReadPieceBlob(id);
    ASSERT_FALSE(blob);
    EXPECT_EQ(blob.GetError().code, ErrorCode::Changed) << blob.GetError().message;
  }
}

TEST_F(StoreTest, AFailedBuildLeavesNothingAndKeepsTheOldStore)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  const std::string digest = this->Build(Torus(96, 48), options).info.digest;
  unsigned calls = 0;
  for (unsigned stopAt = 1; stopAt < 40; stopAt += 3)
  {
    calls = 0;
    Execution execution;
    execution.progress = [&](std::string_view, double) { return ++calls < stopAt; };
    const auto report = BuildStore(DisplacedSphere(5), "x", this->File(), options, execution);
    if (report)
    {
      break;
    }
    EXPECT_EQ(report.GetError().code, ErrorCode::Cancelled);
    EXPECT_EQ(this->FilesInFolder(), 1U) << "a temporary file is left";
    EXPECT_EQ((*Store::Open(this->File()))->Info().digest, digest);
  }
  EXPECT_GT(calls, 10U);
}

// The umask of this process until it goes.
struct Umask
{
  mode_t before;
  explicit Umask(mode_t mask)
    : before(::umask(mask))
  {
  }
  ~Umask() { ::umask(this->before); }
};

TEST_F(StoreTest, ANewStoreHasThePermissionsOfNewFiles)
{
  for (const auto& [mask, expected] :
    { std::pair<mode_t, mode_t>{ 022, 0644 }, { 077, 0600 }, { 027, 0640 }, { 0, 0666 } })
  {
    const Umask umask(mask);
    this->Build(Torus(20, 20), {});
    EXPECT_EQ(PermissionsOf(this->File()), expected);
    fs::remove(this->File());
  }
}

TEST_F(StoreTest, AStoreThatIsReplacedKeepsItsPermissions)
{
  const Umask umask(022);
  for (const mode_t mode : { 0600, 0640, 0664, 0444 })
  {
    this->Build(Torus(20, 20), {});
    ASSERT_EQ(::chmod(this->File().c_str(), mode), 0);
    this->Build(Torus(21, 20), {});
    EXPECT_EQ(PermissionsOf(this->File()), mode);
    ASSERT_TRUE(EditStore(this->File(), { "other", {}, {}, {} }));
    EXPECT_EQ(PermissionsOf(this->File()), mode);
  }
}

// At every report of progress: nobody can open what he could not read in the store.
TEST_F(StoreTest, WhatIsUnfinishedIsNoMoreReadableThanTheStore)
{
  const auto readable = [&](const BuildOptions& options)
  {
    mode_t most = 0;
    unsigned seen = 0;
    Execution execution;
    execution.progress = [&](std::string_view, double)
    {
      for (const fs::directory_entry& entry : fs::directory_iterator(this->Folder))
      {
        if (entry.path() != this->File())
        {
          ++seen;
          most |= PermissionsOf(entry.path());
        }
      }
      return true;
    };
    this->Build(Torus(60, 40), options, execution);
    EXPECT_GT(seen, 0U);
    return most;
  };
  const Umask umask(022);
  EXPECT_EQ(readable({}), mode_t{ 0644 });
  ASSERT_EQ(::chmod(this->File().c_str(), 0600), 0);
  EXPECT_EQ(readable({}), mode_t{ 0600 }) << "the store that is replaced is private";
}

// In a process of its own, since the limit stays: files of at most so many bytes.
TEST_F(StoreTest, AFullDiskSaysHowMuchTheStoreTakes)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 100;
  Mesh mesh = Torus(96, 48);
  // Most of the store is in the original: SQLite holds back 2 MB before it writes.
  std::mt19937 random(1);
  mesh.attributes.push_back(
    { { "bytes", AttributeType::UInt8, AttributeAssociation::Point, 255 }, {} });
  mesh.attributes.push_back(
    { { "more", AttributeType::Float64, AttributeAssociation::Point, 100 }, {} });
  for (Attribute& attribute : mesh.attributes)
  {
    attribute.values.resize(attribute.TupleSize() * mesh.points.size());
    std::generate(attribute.values.begin(), attribute.values.end(),
      [&] { return static_cast<std::uint8_t>(random() & 127); });
  }
  this->Build(mesh, options);
  const auto whole = static_cast<double>(fs::file_size(this->File()));
  ASSERT_GT(whole, 4 << 20);
  fs::remove(this->File());
  for (const double part : { 0.6, 0.8, 0.99 })
  {
    SCOPED_TRACE(part);
    const fs::path said = this->File("said");
    const pid_t child = ::fork();
    if (child == 0)
    {
      std::ofstream report(said);
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{ static_cast<rlim_t>(part * whole), static_cast<rlim_t>(part * whole) };
      ::setrlimit(RLIMIT_FSIZE, &limit);
      const auto built = BuildStore(mesh, "x", this->File(), options);
      report << (built ? "built" : built.GetError().message) << std::flush;
      ::_exit(built || built.GetError().code != ErrorCode::InputOutput ? 1 : 0);
    }
    int state = 0;
    ::waitpid(child, &state, 0);
    EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 0);
    std::ifstream stream(said);
    const std::string text{ std::istreambuf_iterator<char>(stream), {} };
    const std::string begin = "files may not grow so large here: the store takes about ";
    ASSERT_EQ(text.rfind(begin, 0), 0U) << text;
    const double needed = std::stod(text.substr(begin.size())) * (1 << 20);
    EXPECT_GT(needed, 0.8 * whole) << text;
    EXPECT_LT(needed, 1.3 * whole) << text;
    fs::remove(said);
    EXPECT_EQ(this->FilesInFolder(), 0U);
  }
}

TEST_F(StoreTest, TextsAreChangedAndTheContentStays)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  options.title = "Statu";
  options.credit = "somebody";
  const ModelDescription before = this->Build(Torus(96, 48), options).info;
  const auto open = *Store::Open(this->File()); // as a server has it
  const PieceId id{ Resolution::Original(), 32 };
  const auto piece = open->ReadPieceBlob(id);
  const auto edited = EditStore(this->File(), { "Statue", "", {}, std::string(9000, 'u') });
  ASSERT_TRUE(edited) << edited.GetError().message;
  EXPECT_EQ(*open->ReadPieceBlob(id), *piece) << "a file that is open has changed";
  const auto store = *Store::Open(this->File());
  EXPECT_TRUE(store->Verify().empty());
  ModelDescription expected = before;
  expected.title = "Statue";
  expected.credit = "";
  expected.unit = std::string(9000, 'u');
  EXPECT_EQ(MetadataOf(store->Info()), MetadataOf(expected));
  EXPECT_EQ(MetadataOf(*edited), MetadataOf(expected));
  EXPECT_EQ(store->Info().digest, before.digest);
  // And back: nothing is left of it.
  ASSERT_TRUE(EditStore(this->File(), { "Statu", "somebody", {}, "" }));
  EXPECT_EQ(MetadataOf((*Store::Open(this->File()))->Info()), MetadataOf(before));
  EXPECT_EQ(this->FilesInFolder(), 1U);
}

TEST_F(StoreTest, AnEditThatFailsChangesNothing)
{
  this->Build(Torus(96, 48), {});
  const auto bytes = [&]
  {
    std::ifstream stream(this->File(), std::ios::binary);
    return std::string{ std::istreambuf_iterator<char>(stream), {} };
  };
  const std::string whole = bytes();
  Execution cancelled;
  cancelled.progress = [](std::string_view, double) { return false; };
  EXPECT_EQ(
    EditStore(this->File(), { "t", {}, {}, {} }, cancelled).GetError().code, ErrorCode::Cancelled);
  EXPECT_TRUE(bytes() == whole);
  EXPECT_EQ(EditStore(this->File("no.kds"), {}).GetError().code, ErrorCode::NotFound);
  // Another build puts its store in place while this one is copied.
  std::string other;
  Execution replacing;
  replacing.progress = [&](std::string_view, double)
  {
    BuildOptions options;
    options.title = "other";
    EXPECT_TRUE(BuildStore(Torus(20, 20), "x", this->File(), options));
    other = bytes();
    return true;
  };
  const auto edited = EditStore(this->File(), { "t", {}, {}, {} }, replacing);
  ASSERT_FALSE(edited);
  EXPECT_NE(edited.GetError().message.find("was replaced"), std::string::npos);
  EXPECT_TRUE(bytes() == other);
  std::ofstream(this->File("text.kds")) << "no store";
  EXPECT_FALSE(EditStore(this->File("text.kds"), { "t", {}, {}, {} }));
  EXPECT_EQ(this->FilesInFolder(), 2U) << "a temporary file is left";
}

TEST_F(StoreTest, SaysWhatIsWrong)
{
  BuildOptions options;
  options.memory = std::uint64_t{ 1 } << 20;
  ASSERT_TRUE(WriteMesh(this->File("torus.ply"), Torus(96, 48)));
  const auto small = BuildStore(this->File("torus.ply"), this->File(), options);
  ASSERT_FALSE(small);
  EXPECT_EQ(small.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_NE(small.GetError().message.find("the limit is 1 MiB"), std::string::npos)
    << small.GetError().message;
  EXPECT_FALSE(fs::exists(this->File()));

  EXPECT_EQ(
    BuildStore(Mesh{}, "x", this->File(), {}).GetError().message, "the mesh has no vertices");
  const Mesh wide{ { { -1.7e308, 0, 0 }, { 1.7e308, 0, 0 } }, {}, ScalarType::Float64 };
  EXPECT_EQ(BuildStore(wide, "x", this->File(), {}).GetError().message,
    "the mesh spans more than 2^127 (1.7e38) along x, the most that levels can be computed for");
  const auto unwritable = BuildStore(Torus(9, 9), "x", this->Folder / "no" / "x.kds", {});
  EXPECT_EQ(unwritable.GetError().code, ErrorCode::InputOutput);
  EXPECT_EQ(Store::Open(this->File("absent.kds")).GetError().code, ErrorCode::NotFound);
  std::ofstream(this->File("text.kds"))
    << "this is no store, but long enough to be mistaken for one ...........";
  EXPECT_FALSE(Store::Open(this->File("text.kds")));
}

TEST_F(StoreTest, NamesWithOddCharactersWork)
{
  for (const char* name : { "a b.kds", "100%?x=1#.kds", "ümlaut.kds", "'quote\".kds" })
  {
    SCOPED_TRACE(name);
    ASSERT_TRUE(BuildStore(Torus(9, 9), "x", this->File(name), {}));
    const auto store = Store::Open(this->File(name));
    ASSERT_TRUE(store) << store.GetError().message;
    EXPECT_TRUE((*store)->Verify().empty());
  }
}

TEST_F(StoreTest, LevelsOfLosslessStoresHaveTheInputsType)
{
  const Mesh offset = DisplacedSphere(4, { 4e6 + 0.123, 5e6, 7 }, 0.5);
  Mesh asDoubles = offset;
  asDoubles.scalarType = ScalarType::Float64;
  this->Build(asDoubles, Lossless(true));
  const Mesh all = GlueAll(**Store::Open(this->File()));
  EXPECT_EQ(PointMultiset(all), PointMultiset(asDoubles))
    << "doubles far from the origin survive exactly";
  BuildOptions grid;
  this->Build(asDoubles, grid);
  const auto store = *Store::Open(this->File());
  const Mesh onGrid = GlueAll(*store);
  EXPECT_LT(store->Info().grid.step, 2e-6);
  const Box box = BoxOfPoints(onGrid.points), input = BoxOfPoints(asDoubles.points);
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(box.lo[k], input.lo[k], store->Info().grid.step);
    EXPECT_NEAR(box.hi[k], input.hi[k], store->Info().grid.step);
  }
}
