// SPDX-License-Identifier: BSD-3-Clause
// A server with quotas, on real sockets.
#include "Testing/Fixtures/Eventually.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "filters/store/Sqlite.h"
#include "server/access/Testing/ForgedToken.h"
#include "server/http/Testing/ServerTest.h"

#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

class QuotaServer : public ServerTest
{
protected:
  const fixtures::TemporaryFolder folder;
  std::vector<PartitionRecord> taken;

  std::shared_ptr<QuotaBook> Book(const QuotaLimits& limits) const
  {
    auto book = QuotaBook::Open(this->folder.Path / "quotas.db", limits);
    EXPECT_TRUE(book) << book.GetError().message;
    return std::move(*book);
  }
  std::uint16_t StartWith(const QuotaLimits& limits)
  {
    this->options.guard =
      std::make_shared<TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; });
    this->options.quotas = this->Book(limits);
    this->options.onPartition = [this](const PartitionRecord& record)
    { this->taken.push_back(record); };
    return this->Start();
  }
  void TearDown() override { this->server.reset(); }

  static std::string Token(const std::string& subject)
  {
    return forged::Token(
      forged::header, "{\"sub\":\"" + subject + R"(","exp":2000,"models":"*","detail":"regions"})");
  }
  static std::string Bearer(const std::string& subject)
  {
    return "Authorization: Bearer " + Token(subject) + "\r\n";
  }
  HttpTestClient::Response Get(std::uint16_t port, std::uint32_t partition,
    const std::string& fields, const std::string& method = "GET") const
  {
    return *HttpTestClient(port).Get(this->Blob(BlobId::Partition(partition)), fields, method);
  }
};

QuotaLimits Share(double share)
{
  QuotaLimits limits;
  limits.share = share;
  return limits;
}

}

TEST_F(QuotaServer, GivesEachNameItsShare)
{
  const auto port = this->StartWith(Share(2.5 / 128));
  EXPECT_EQ(this->Get(port, 3, Bearer("ann")).status, 200u);
  // A request for which no byte of the blob is sent does not count.
  EXPECT_EQ(this->Get(port, 4, Bearer("ann"), "HEAD").status, 200u);
  EXPECT_EQ(this->Get(port, 5, Bearer("ann") + "If-None-Match: *\r\n").status, 304u);
  EXPECT_EQ(this->Get(port, 5, Bearer("ann") + "Range: bytes=999999-\r\n").status, 416u);
  EXPECT_EQ(this->Get(port, 6, Bearer("ann") + "Range: bytes=0-9\r\n").status, 206u);
  const auto refused = this->Get(port, 7, Bearer("ann"));
  EXPECT_EQ(refused.status, 403u);
  EXPECT_NE(refused.body.find("the quota of 2 partitions of this model is used up: try again at "),
    std::string::npos);
  const int seconds = std::stoi(refused.Field("Retry-After"));
  EXPECT_GT(seconds, 86400 - 100);
  EXPECT_LE(seconds, 86400);
  // Streams count against the same quota.
  StreamTestClient client(port);
  ASSERT_TRUE(client.Open("kdstream.v2, " + Token("ann")));
  client.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(client.Await(1).opened);
  client.Ask({ 2, AskPartitions({ 3, 6, 7 }) });
  const auto answer = client.Await(2);
  EXPECT_EQ(answer.blobs.size(), 2u);
  ASSERT_TRUE(answer.error);
  EXPECT_EQ(answer.error->code, 403u);

  EXPECT_EQ(this->Get(port, 7, Bearer("bob")).status, 200u);
  HttpTestClient watcher(port);
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"quota\"} 2\n", watcher));
  this->server.reset();
  ASSERT_EQ(this->taken.size(), 5u); // 3 and 6, both again by stream, and bob's
  EXPECT_EQ(this->taken.back().subject, "bob");
  EXPECT_EQ(this->taken.back().client, "127.0.0.1");
}

TEST_F(QuotaServer, BytesTooFastAreToBeAskedForAgain)
{
  QuotaLimits limits;
  limits.bytesPerSecond = 100; // one partition has some 20,000 bytes: the rate of many seconds
  const auto port = this->StartWith(limits);
  EXPECT_EQ(this->Get(port, 3, Bearer("ann")).status, 200u);
  const auto refused = this->Get(port, 3, Bearer("ann"));
  EXPECT_EQ(refused.status, 429u);
  EXPECT_GT(std::stoi(refused.Field("Retry-After")), 60);
}

// Neither the only thread of the event loop nor the only reader waits for the quotas' file. Only
// requests for the original wait.
TEST_F(QuotaServer, AFileThatIsLockedDelaysOnlyThoseWhoTake)
{
  this->options.threads = 1;
  this->options.readers = 1;
  auto limits = Share(0.5);
  limits.regionsPerMinute = 10;
  const auto port = this->StartWith(limits);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open("kdstream.v2, " + Token("ann")));
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);
  const auto other = OpenForWriting(this->folder.Path / "quotas.db");
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  HttpTestClient reader(port), watcher(port);
  reader.Send("GET " + this->Blob(BlobId::Partition(3)) + " HTTP/1.1\r\nHost: x\r\n" +
              Bearer("ann") + "\r\n");
  stream.Ask({ 2, RegionRequest{ 128, 0, {} } });
  // the request that opened the model is the other one
  EXPECT_TRUE(fixtures::Eventually(
    [&] { return MetricsHave("kdstream_reader_wait_seconds_count 2\n", watcher); }));
  EXPECT_EQ(watcher.Get(this->Blob(BlobId::LevelPiece(0, 1)), Bearer("bob"))->status, 200u);
  ASSERT_TRUE(Execute(other->get(), "COMMIT")); // before the server gives up
  EXPECT_EQ(reader.Receive()->status, 200u);
  EXPECT_TRUE(stream.Await(2).end);
}

// If the tag is not the blob's, the whole blob is sent, which counts. If it is, nothing is sent or
// counted.
TEST_F(QuotaServer, AFileThatIsLockedDelaysOnlyThoseWhoTakeWhateverTheyHave)
{
  this->options.threads = 1;
  this->options.readers = 1;
  const auto port = this->StartWith(Share(0.5));
  const auto other = OpenForWriting(this->folder.Path / "quotas.db");
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  const auto blob = this->Blob(BlobId::Partition(3));
  HttpTestClient reader(port), watcher(port);
  reader.Send("GET " + blob + " HTTP/1.1\r\nHost: localhost\r\nIf-None-Match: \"x\"\r\n" +
              Bearer("ann") + "\r\n");
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!MetricsHave("kdstream_reader_wait_seconds_count 1\n", watcher) &&
         std::chrono::steady_clock::now() < until)
  {
  }
  EXPECT_EQ(watcher.Get(this->Blob(BlobId::LevelPiece(0, 1)), Bearer("bob"))->status, 200u);
  const auto tag = "\"" + this->model->Description().digest + "/partitions/3\"";
  EXPECT_EQ(watcher.Get(blob, "If-None-Match: " + tag + "\r\n" + Bearer("bob"))->status, 304u);
  ASSERT_TRUE(Execute(other->get(), "COMMIT")); // before the server gives up
  EXPECT_EQ(reader.Receive()->status, 200u);
}

// For a range beyond the partition's end nothing is sent or counted, however many requests wait.
TEST_F(QuotaServer, AFileThatIsLockedDelaysNoRangeThatLiesBeyond)
{
  this->options.threads = 1;
  this->options.readers = 1;
  const auto port = this->StartWith(Share(0.5));
  const auto other = OpenForWriting(this->folder.Path / "quotas.db");
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  HttpTestClient taker(port), ranger(port), watcher(port);
  const auto ask = [this](HttpTestClient& client, std::uint32_t partition, const std::string& more)
  {
    client.Send("GET " + this->Blob(BlobId::Partition(partition)) + " HTTP/1.1\r\nHost: x\r\n" +
                more + Bearer("ann") + "\r\n");
  };
  ask(taker, 3, "");
  ask(ranger, 4, "Range: bytes=0-9\r\n");
  for (std::uint32_t partition = 3; partition < 6; ++partition)
  {
    const auto beyond = this->Get(port, partition, "Range: bytes=999999-\r\n" + Bearer("bob"));
    EXPECT_EQ(beyond.status, 416u);
  }
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"quota\"} 0\n", watcher));
  ASSERT_TRUE(Execute(other->get(), "COMMIT")); // before the server gives up
  EXPECT_EQ(taker.Receive()->status, 200u);
  EXPECT_EQ(ranger.Receive()->status, 206u);
  this->server.reset();
  EXPECT_EQ(this->taken.size(), 2u);
}

// Clients of two servers with the same quota file, all at the same time, never exceed the quota.
TEST_F(QuotaServer, TwoWithOneFileGiveWhatOneWould)
{
  const auto limits = Share(20.0 / 128);
  const auto port = this->StartWith(limits);
  auto more = this->options;
  more.quotas = this->Book(limits);
  more.onPartition = {};
  more.onAccess = {};
  const auto second = HttpServer::Start(this->catalog, more);
  ASSERT_TRUE(second);
  const std::uint16_t ports[] = { port, (*second)->Port() };
  std::vector<std::set<std::uint32_t>> had(6);
  std::vector<std::thread> clients;
  for (std::uint32_t i = 0; i < had.size(); ++i)
  {
    clients.emplace_back(
      [&, i]
      {
        for (std::uint32_t k = 0; k < 40; ++k)
        {
          const auto partition = (k * 3 + i * 21) % 128;
          if (this->Get(ports[i % 2], partition, Bearer("ann")).status == 200)
          {
            had[i].insert(partition);
          }
        }
      });
  }
  for (auto& client : clients)
  {
    client.join();
  }
  std::set<std::uint32_t> all;
  for (const auto& each : had)
  {
    all.insert(each.begin(), each.end());
  }
  EXPECT_EQ(all.size(), 20u);
}
