// SPDX-License-Identifier: BSD-3-Clause
// What readers get while their store is replaced by a rename, overwritten in place, or truncated:
// the bytes of the digest that they asked for, or an error that says that these are gone.
#include "Testing/Fixtures/Eventually.h"
#include "server/http/HttpServer.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/session/StoreCatalog.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;
namespace fs = std::filesystem;

namespace
{

constexpr unsigned readers = 16;

Mesh Sheet(std::uint32_t side, double height)
{
  Mesh mesh;
  for (std::uint32_t i = 0; i < side; ++i)
  {
    for (std::uint32_t j = 0; j < side; ++j)
    {
      mesh.points.push_back({ i * 0.25, j * 0.125, height * std::floor(10 * std::sin(i * 0.1)) });
      if (i > 0 && j > 0)
      {
        const VertexId v = i * side + j;
        mesh.triangles.push_back({ v - side - 1, v - side, v });
        mesh.triangles.push_back({ v - side - 1, v, v - 1 });
      }
    }
  }
  return mesh;
}

// Counts what the readers have seen, by status (200: a whole blob with the right bytes).
class Tally
{
public:
  void Count(unsigned status)
  {
    const std::lock_guard lock(this->Mutex);
    ++this->Seen[status];
    ++this->All;
  }
  std::map<unsigned, std::size_t> Statuses() const
  {
    const std::lock_guard lock(this->Mutex);
    return this->Seen;
  }
  std::size_t Total() const { return this->All; }

  // Each reader calls this once, when it is connected and has opened the model.
  void Begin() { ++this->Begun; }
  unsigned Readers() const { return this->Begun; }

private:
  mutable std::mutex Mutex;
  std::map<unsigned, std::size_t> Seen;
  std::atomic<std::size_t> All{ 0 };
  std::atomic<unsigned> Begun{ 0 };
};

constexpr unsigned foreign = 1; // not a status: bytes of another model

class ReplacedStores : public testing::Test
{
protected:
  const fixtures::TemporaryFolder folder;
  fs::path served = this->folder / "served" / "m.kds", old = this->folder / "old.kds",
           fresh = this->folder / "new.kds";
  StoreCatalog catalog{ this->folder / "served", [](const fs::path&, const std::string&) {} };
  std::unique_ptr<HttpServer> server;
  std::map<std::string, std::string> blobs; // by path, which includes the digest
  ModelDescription reported;                // of the old model

  void SetUp() override
  {
    fs::create_directories(this->served.parent_path());
    this->reported = this->Build(this->old, 1);
    (void)this->Build(this->fresh, 2);
    fs::copy_file(this->old, this->served);
    ASSERT_TRUE(this->catalog.Reload());
    HttpServerOptions options;
    options.threads = 4;
    options.drainTimeout = std::chrono::milliseconds(0);
    auto started = HttpServer::Start(this->catalog, options);
    ASSERT_TRUE(started);
    this->server = std::move(*started);
  }

  ModelDescription Build(const fs::path& file, double height)
  {
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    auto report = BuildStore(Sheet(60, height), "sheet.ply", file, options);
    EXPECT_TRUE(report);
    const auto& info = report->info;
    const auto store = *Store::Open(file);
    for (std::uint32_t p = 0; p < info.partitions; ++p)
    {
      const auto bytes = *store->Read(BlobOfPiece(
        { Resolution::Original(), NodeOfPartition(p, info.depths) }, store->Info().depths));
      this->blobs[BlobPath("m", info.digest, BlobId::Partition(p))] = { bytes.begin(),
        bytes.end() };
    }
    return info;
  }

  // Reads the partitions of the old model, one by one.
  void ReadByGet(Tally& tally, const std::atomic<bool>& stop) const
  {
    HttpTestClient client(this->server->Port());
    tally.Begin();
    for (std::uint32_t p = 0; !stop;
         p = (p + 1) % static_cast<std::uint32_t>(this->reported.partitions))
    {
      const auto path = BlobPath("m", this->reported.digest, BlobId::Partition(p));
      const auto answer = client.Get(path);
      const bool wrong = answer && answer->status == 200 && answer->body != this->blobs.at(path);
      tally.Count(!answer ? 0 : wrong ? foreign : answer->status);
    }
  }

  void ReadByStream(Tally& tally, const std::atomic<bool>& stop) const
  {
    StreamTestClient client(this->server->Port());
    EXPECT_TRUE(client.Open());
    client.Ask({ 1, OpenRequest{ "m" } });
    const auto opened = client.Await(1).opened;
    tally.Begin();
    ASSERT_TRUE(opened);
    std::vector<std::uint32_t> all(opened->model.partitions);
    for (std::uint32_t p = 0; p < all.size(); ++p)
    {
      all[p] = p;
    }
    for (std::uint32_t request = 2; !stop; ++request)
    {
      client.Ask({ request, AskPartitions(all) });
      const auto answer = client.Await(request);
      for (const auto& blob : answer.blobs)
      {
        const std::string bytes(blob.bytes.begin(), blob.bytes.end());
        tally.Count(
          bytes == this->blobs.at(BlobPath("m", opened->model.digest, blob.id)) ? 200 : foreign);
      }
      for (const auto& error : answer.blobErrors)
      {
        tally.Count(error.code);
      }
      tally.Count(answer.error ? answer.error->code : answer.end ? 200u : 0u);
    }
  }

  // Counts what 16 readers see of `replace`, which is called while all of them read.
  template <class Replace>
  std::map<unsigned, std::size_t> SeenWhile(const Replace& replace) const
  {
    Tally tally;
    std::atomic<bool> stop{ false };
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < readers; ++i)
    {
      threads.emplace_back(
        [&, i] { i % 2 == 0 ? this->ReadByGet(tally, stop) : this->ReadByStream(tally, stop); });
    }
    const auto wait = [&tally](std::size_t more)
    {
      const auto before = tally.Total();
      EXPECT_TRUE(fixtures::Eventually([&] { return tally.Total() >= before + more; }));
    };
    // wait for this first: a model that is being replaced cannot be opened
    EXPECT_TRUE(fixtures::Eventually([&] { return tally.Readers() >= readers; }));
    wait(500);
    replace();
    wait(500);
    stop = true;
    for (auto& thread : threads)
    {
      thread.join();
    }
    return tally.Statuses();
  }

  void OverwriteInPlace() const
  {
    std::ifstream in(this->fresh, std::ios::binary);
    std::ofstream out(this->served, std::ios::binary);
    out << in.rdbuf();
  }
};

}

TEST_F(ReplacedStores, ARenameLeavesReadersOnTheOldStore)
{
  const auto seen = this->SeenWhile(
    [this]
    {
      fs::rename(this->fresh, this->served);
      ASSERT_TRUE(this->catalog.Reload()); // the old digest can still be read
    });
  EXPECT_EQ(seen.size(), 1u) << "not only 200";
  EXPECT_EQ(seen.count(200), 1u);
}

TEST_F(ReplacedStores, AnOverwriteInPlaceIsSeen)
{
  auto seen = this->SeenWhile([this] { this->OverwriteInPlace(); });
  EXPECT_GT(seen[200], 0u);
  EXPECT_GT(seen[410], 0u);
  EXPECT_EQ(seen[200] + seen[410], seen[0] + seen[200] + seen[410] + seen[foreign] + seen[500]);

  HttpTestClient client(this->server->Port());
  const auto refused = client.Get("/api/models/m/model.json");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503u);
  EXPECT_EQ(refused->Field("Retry-After"), "1");
  this->catalog.Refresh();
  const auto model = client.Get("/api/models/m/model.json");
  ASSERT_TRUE(model);
  ASSERT_EQ(model->status, 200u);
  const auto path = BlobPath("m", ParseModel(model->body)->digest, BlobId::Partition(0));
  EXPECT_EQ(client.Get(path)->body, this->blobs.at(path));
}

TEST_F(ReplacedStores, ATruncationIsSeen)
{
  auto seen =
    this->SeenWhile([this] { fs::resize_file(this->served, fs::file_size(this->served) / 2); });
  EXPECT_GT(seen[410], 0u);
  EXPECT_EQ(seen[foreign] + seen[0] + seen[500], 0u);
  HttpTestClient client(this->server->Port());
  EXPECT_EQ(client.Get("/healthz")->status, 200u);
  EXPECT_EQ(client.Get("/api/models/m/model.json")->status, 503u) << "it may still be written";
  ASSERT_TRUE(this->catalog.Reload());
  const auto refused = client.Get("/api/models/m/model.json");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 500u) << "final";
  EXPECT_EQ(refused->Field("Retry-After"), "");
  const auto blob = BlobPath("m", this->reported.digest, BlobId::Partition(0));
  EXPECT_EQ(client.Get(blob)->status, 410u);
  StreamTestClient stream(this->server->Port());
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "m" } });
  const auto answer = stream.Await(1);
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->code, 500u);
}
