// SPDX-License-Identifier: BSD-3-Clause
// A disk that hangs on one store: clients of that store wait, and are asked to try again; other
// clients are not affected.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/Testing/ServerTest.h"

#include <fstream>
#include <future>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;
using namespace std::chrono_literals;

namespace
{

class Disks : public ServerTest
{
protected:
  std::shared_ptr<MemoryModel> other = this->catalog.Add("other", 2, 4, 1000);
  std::vector<std::unique_ptr<HttpTestClient>> askers;
  std::vector<std::unique_ptr<StreamTestClient>> streams;

  // Ends the hang of the disk in any case, so that a failing test does not wait forever.
  std::promise<void> over;
  std::thread deadline;

  void SetUp() override
  {
    this->options.threads = 1;
    this->options.readers = 2;
    this->deadline = std::thread(
      [this, isOver = this->over.get_future()]
      {
        if (isOver.wait_for(20s) == std::future_status::timeout)
        {
          ADD_FAILURE() << "somebody waits for the disk who should not";
          this->SetHanging(false);
        }
      });
  }
  void TearDown() override
  {
    this->over.set_value();
    this->deadline.join();
    this->SetHanging(false);
    this->server.reset();
  }
  void SetHanging(bool hangs) const
  {
    this->model->diskHangs = hangs;
    this->model->diskHangs.notify_all();
  }
  // Requests a partition of the store whose disk hangs.
  void Ask(std::uint16_t port, std::uint32_t partition)
  {
    this->askers.push_back(std::make_unique<HttpTestClient>(port));
    this->askers.back()->Send(
      "GET " + this->Blob(BlobId::Partition(partition)) + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  std::string OtherBlob() const
  {
    return BlobPath("other", this->other->Description().digest, BlobId::Partition(0));
  }
  // Whether the metrics contain the line before long.
  static bool Has(HttpTestClient& client, const std::string& line)
  {
    const auto until = std::chrono::steady_clock::now() + 20s;
    bool has = false;
    while (!has && std::chrono::steady_clock::now() < until)
    {
      has = MetricsHave(line, client);
    }
    return has;
  }
};

}

TEST_F(Disks, AnyNumberWhoAskForAStoreThatHangsDelayNobodyElse)
{
  const auto port = this->Start();
  constexpr std::uint32_t eachWay = 60;
  for (std::uint32_t i = 0; i < 4; ++i)
  {
    this->streams.push_back(std::make_unique<StreamTestClient>(port));
    ASSERT_TRUE(this->streams.back()->Open());
    this->streams.back()->Ask({ 1, OpenRequest{ "dragon" } });
    ASSERT_TRUE(this->streams.back()->Await(1).opened);
  }
  this->SetHanging(true);
  for (std::uint32_t p = 0; p < eachWay; ++p)
  {
    this->Ask(port, p);
    this->Ask(port, 7);
  }
  for (const auto& stream : this->streams)
  {
    stream->Ask({ 2, RegionRequest{ 1, 1, {} } });
  }
  HttpTestClient client(port);
  // Including the four tasks that have opened the model.
  ASSERT_TRUE(Has(
    client, "kdstream_reader_queue_length_count " + std::to_string(4 + 2 * eachWay + 4) + "\n"));
  EXPECT_EQ(this->model->hanging, 1);
  EXPECT_EQ(client.Get(this->OtherBlob())->status, 200u);
  EXPECT_EQ(client.Get("/readyz")->status, 200u);
  EXPECT_EQ(client.Get("/api/models/dragon/model.json")->status, 200u);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "other" } });
  ASSERT_TRUE(stream.Await(1).opened);
  stream.Ask({ 2, AskPartitions({ 1, 2 }) });
  EXPECT_EQ(stream.Await(2).blobs.size(), 2u);
  this->SetHanging(false);
  for (const auto& asker : this->askers)
  {
    const auto answer = asker->Receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 200u);
  }
  for (const auto& each : this->streams)
  {
    EXPECT_TRUE(this->IsRegion(each->Await(2), 1, 1));
  }
}

// Tiles and pictures of a store that hangs do not delay tiles and pictures of other models.
TEST_F(Disks, TilesAndPicturesOfAStoreThatHangsDelayNoOthers)
{
  const fixtures::TemporaryFolder pages;
  std::ofstream(pages / "index.html") << "home";
  this->options.web = *StaticFiles::Open(pages.Path);
  const auto port = this->Start();
  this->SetHanging(true);
  constexpr int askersOfEach = 20;
  const std::vector<std::string> made{ "/api/models/dragon/3dtiles/tileset.json",
    "/m/dragon/picture.jpg" };
  for (int i = 0; i < askersOfEach; ++i)
  {
    for (const auto& path : made)
    {
      this->askers.push_back(std::make_unique<HttpTestClient>(port));
      this->askers.back()->Send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    }
  }
  HttpTestClient client(port);
  ASSERT_TRUE(
    Has(client, "kdstream_reader_queue_length_count " + std::to_string(2 * askersOfEach) + "\n"));
  const auto before = this->other->reads.load();
  for (std::string path : made)
  {
    const auto answer = client.Get(path.replace(path.find("dragon"), 6, "other"));
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 500u) << "its blobs are random: " << answer->body;
  }
  EXPECT_GE(this->other->reads, before + 2) << "they have been read";
  EXPECT_EQ(client.Get(this->OtherBlob())->status, 200u);
  this->SetHanging(false);
}

TEST_F(Disks, WhoWaitsForTooLongGetsABusyAnswer)
{
  this->options.answerTimeout = 300ms;
  const auto port = this->Start();
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);
  this->SetHanging(true);
  this->Ask(port, 0);
  stream.Ask({ 2, AskPartitions({ 1, 2, 3 }) });
  const auto refused = this->askers[0]->Receive();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503u);
  EXPECT_EQ(refused->Field("Retry-After"), "1");
  const auto missing = stream.Await(2);
  EXPECT_EQ(missing.blobErrors.size(), 3u);
  for (const auto& error : missing.blobErrors)
  {
    EXPECT_EQ(error.code, 503);
  }
  EXPECT_TRUE(missing.end);
  HttpTestClient client(port);
  EXPECT_TRUE(Has(client, "kdstream_failures_total{what=\"disk\"} 4\n"));
  EXPECT_TRUE(Has(client, "kdstream_reader_queue 0\n"));
  EXPECT_EQ(client.Get(this->OtherBlob())->status, 200u);

  this->SetHanging(false);
  const auto until = std::chrono::steady_clock::now() + 20s;
  unsigned status = 0;
  while (status != 200 && std::chrono::steady_clock::now() < until)
  {
    const auto answer = HttpTestClient(port).Get(this->Blob(BlobId::Partition(0)));
    status = answer ? answer->status : 0;
  }
  EXPECT_EQ(status, 200u);
  stream.Ask({ 3, AskPartitions({ 1, 2, 3 }) });
  EXPECT_EQ(stream.Await(3).blobs.size(), 3u);
}

// Otherwise a thousand clients that wait for a disk would keep everybody else out.
TEST_F(Disks, WhoWaitsForADiskLosesTheSlotToOthers)
{
  this->options.maximumConnections = 4;
  const auto port = this->Start();
  this->SetHanging(true);
  for (std::uint32_t p = 0; p < 4; ++p)
  {
    this->Ask(port, p);
  }
  const auto until = std::chrono::steady_clock::now() + 20s;
  unsigned status = 0;
  while (status != 200 && std::chrono::steady_clock::now() < until)
  {
    const auto answer = HttpTestClient(port).Get(this->OtherBlob());
    status = answer ? answer->status : 0;
  }
  EXPECT_EQ(status, 200u);
  const auto refused = this->askers[0]->Receive();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503u);
}

TEST_F(Disks, AnEndIsNotWaitedForLongerThanItMay)
{
  const auto port = this->Start();
  this->SetHanging(true);
  this->Ask(port, 0);
  HttpTestClient client(port);
  ASSERT_TRUE(Has(client, "kdstream_reader_wait_seconds_count 1\n"));
  EXPECT_FALSE(this->server->StopWithin(10ms));
  this->SetHanging(false);
  EXPECT_TRUE(this->server->StopWithin(20s));
}
