// SPDX-License-Identifier: BSD-3-Clause
// StoreWriter: a store exists completely or not at all, and nobody can read an unfinished store who
// could not read the finished one.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreWriter.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <random>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class StoreWriterTest : public StoreTest
{
};

mode_t PermissionsOf(const fs::path& file)
{
  struct stat state = {};
  EXPECT_EQ(::lstat(file.c_str(), &state), 0);
  return state.st_mode & 0777;
}

// Sets the umask of this process while it exists.
struct Umask
{
  mode_t before;
  explicit Umask(mode_t mask)
    : before(::umask(mask))
  {
  }
  ~Umask() { ::umask(this->before); }
};

}

TEST_F(StoreWriterTest, ABlobThatNoServerSendsIsNotWritten)
{
  this->Build(Torus(12, 6), {});
  const auto whole = *Store::Open(this->File());
  auto writer = StoreWriter::Create(this->File("large.kds"), whole->Info());
  ASSERT_TRUE(writer);
  const PieceId id{ Resolution::Original(), NodeOfPartition(0, whole->Info().depths) };
  const Piece piece = *whole->ReadPiece(id);
  const std::vector<std::uint8_t> bytes(protocol::maximumBlobBytes + 1);
  const Status refused = (*writer)->AddPiece(piece, bytes);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(FailsAt(refused, ErrorCode::LimitExceeded, "partitions/0"));
}

// Tested with a noisy scan of 41,000 vertices, because schema, metadata and directory do not shrink
// with the mesh.
TEST_F(StoreWriterTest, TheContainerTakesAtMostATwentiethOfTheBlobs)
{
  Mesh scan = DisplacedSphere(7);
  std::mt19937 random(1);
  for (Vec3& point : scan.points)
  {
    point[0] += double(random() % 1000) * 1e-6;
  }
  BuildOptions options;
  for (const std::uint8_t bits : { std::uint8_t{ 14 }, std::uint8_t{ 20 } })
  {
    options.bits = bits;
    const ModelDescription info = this->Build(scan, options).info;
    std::uint64_t blobs = 0;
    const auto store = *Store::Open(this->File());
    for (const PieceId id : store->PieceIds())
    {
      blobs += *store->Size(BlobOfPiece(id, info.depths));
    }
    const std::uint64_t bytes = fs::file_size(this->File());
    EXPECT_LT(double(bytes), 1.05 * double(blobs)) << bytes << " for " << blobs;
  }
}

TEST_F(StoreWriterTest, AFailedBuildLeavesNothingAndKeepsTheOldStore)
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

TEST_F(StoreWriterTest, ANewStoreHasThePermissionsOfNewFiles)
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

TEST_F(StoreWriterTest, AStoreThatIsReplacedKeepsItsPermissions)
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

// At every report of progress, an unfinished file must not be readable by more users than the
// store.
TEST_F(StoreWriterTest, AnUnfinishedFileHasThePermissionsOfTheStore)
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

// Limits the size of files. Runs in a process of its own, because the limit stays.
TEST_F(StoreWriterTest, AFullDiskSaysHowMuchTheStoreTakes)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 100;
  Mesh mesh = Torus(96, 48);
  // SQLite holds back 2 MB before it writes, so most of the store must be in the original.
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
      ::_exit(built || built.GetError().code != ErrorCode::DiskFull ? 1 : 0);
    }
    int state = 0;
    ::waitpid(child, &state, 0);
    EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 0);
    const std::string text = ReadWhole(said);
    const std::string begin = "files cannot grow this large here: the store needs about ";
    ASSERT_EQ(text.rfind(begin, 0), 0U) << text;
    const double needed = std::stod(text.substr(begin.size())) * (1 << 20);
    EXPECT_GT(needed, 0.8 * whole) << text;
    EXPECT_LT(needed, 1.3 * whole) << text;
    fs::remove(said);
    EXPECT_EQ(this->FilesInFolder(), 0U);
  }
}
