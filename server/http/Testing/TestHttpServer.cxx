// SPDX-License-Identifier: BSD-3-Clause
// The server on real sockets: what the routes and the conversation cannot show by themselves.
#include "server/http/HttpServer.h"

#include "filters/core/tree/Region.h"
#include "filters/model/ModelJson.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/protocol/ResourcePath.h"
#include "server/protocol/Testing/RandomMessages.h"
#include "server/session/Testing/MemoryCatalog.h"

#define XXH_INLINE_ALL
#include <gtest/gtest.h>
#include <xxhash.h>

#include <atomic>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

class Server : public testing::Test
{
protected:
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 7, 20000);
  HttpServerOptions options;
  std::mutex mutex;
  std::vector<AccessRecord> records;
  std::unique_ptr<HttpServer> server;

  std::uint16_t Start()
  {
    this->options.onAccess = [this](const AccessRecord& record)
    {
      const std::lock_guard lock(this->mutex);
      this->records.push_back(record);
    };
    this->options.drainTimeout = std::chrono::milliseconds(500);
    auto started = HttpServer::Start(this->catalog, this->options);
    EXPECT_TRUE(started) << started.GetError().message;
    this->server = std::move(*started);
    return this->server->Port();
  }

  static bool MetricsHave(const std::string& line, HttpTestClient& client)
  {
    const auto metrics = client.Get("/metrics");
    return metrics && metrics->body.find(line) != std::string::npos;
  }

  std::string Blob(const BlobId& id) const
  {
    return BlobPath("dragon", this->model->Description().digest, id);
  }

  static XXH64_hash_t Hash(const std::vector<std::uint8_t>& bytes)
  {
    return XXH3_64bits(bytes.data(), bytes.size());
  }

  std::vector<std::uint32_t> Region(std::uint32_t cell, unsigned rings) const
  {
    return *FindRegion(this->model->TrueBoxes(), this->model->GetDepths(), cell, rings);
  }

  // Whether the blobs are the region's, in order, byte for byte.
  bool IsRegion(const StreamTestClient::Answer& answer, std::uint32_t cell, unsigned rings) const
  {
    const auto region = this->Region(cell, rings);
    bool good = answer.end && answer.blobs.size() == region.size();
    for (std::size_t i = 0; good && i < region.size(); ++i)
    {
      const auto id = BlobId::Partition(region[i]);
      good =
        answer.blobs[i].id == id && Hash(answer.blobs[i].bytes) == Hash(*this->model->blobs.at(id));
    }
    return good;
  }
};

}

TEST_F(Server, AnswersManyRequestsOnOneConnection)
{
  HttpTestClient client(this->Start());
  const auto models = client.Get("/api/models.json");
  ASSERT_TRUE(models);
  EXPECT_EQ(models->status, 200u);
  EXPECT_EQ(ParseModelList(models->body)->at(0).id, "dragon");
  EXPECT_FALSE(models->Field("Date").empty());
  for (const auto& [id, bytes] : this->model->blobs)
  {
    const auto blob = client.Get(this->Blob(id));
    ASSERT_TRUE(blob);
    EXPECT_EQ(blob->body, std::string(bytes->begin(), bytes->end()));
  }
  const auto tag = models->Field("ETag");
  const auto unchanged = client.Get("/api/models.json", "If-None-Match: " + tag + "\r\n");
  ASSERT_TRUE(unchanged);
  EXPECT_EQ(unchanged->status, 304u);
  EXPECT_TRUE(unchanged->body.empty());
  const auto part = client.Get(this->Blob(BlobId::Partition(0)), "Range: bytes=5-9\r\n");
  ASSERT_TRUE(part);
  EXPECT_EQ(part->status, 206u);
  const auto& whole = *this->model->blobs.at(BlobId::Partition(0));
  EXPECT_EQ(part->body, std::string(whole.begin() + 5, whole.begin() + 10));
  EXPECT_EQ(client.Get(this->Blob(BlobId::Partition(0)), "Range: bytes=999999-\r\n")->status, 416u);
  const auto head = client.Get(this->Blob(BlobId::Partition(0)), "", "HEAD");
  ASSERT_TRUE(head);
  EXPECT_EQ(head->Field("Content-Length"), std::to_string(whole.size()));
  EXPECT_EQ(client.Get("/api/nothing")->status, 404u);
  EXPECT_EQ(client.Get("/healthz", "", "POST")->status, 405u);
  EXPECT_EQ(client.Get("/healthz")->body, "ok\n");
  this->server->Stop(); // an answer is logged after it has been sent
  EXPECT_EQ(this->records.size(), this->model->blobs.size() + 8);
  EXPECT_EQ(this->records[0].target, "/api/models.json");
  EXPECT_EQ(this->records[0].bytes, models->body.size());
  EXPECT_EQ(this->records[0].client, "127.0.0.1");
}

TEST_F(Server, WantOfMemoryIsToldAndTheConnectionGoesOn)
{
  const auto port = this->Start();
  HttpTestClient client(port);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);

  this->model->throws = true;
  const auto refused = client.Get(this->Blob(BlobId::Partition(0)));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503u);
  EXPECT_EQ(refused->Field("Retry-After"), "1");
  stream.Ask({ 2, RegionRequest{ 1, 1, {} } });
  const auto error = stream.Await(2).error;
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, 503);
  stream.Ask({ 3, PartitionsRequest{ { 0 } } });
  const auto missing = stream.Await(3);
  ASSERT_EQ(missing.blobErrors.size(), 1u);
  EXPECT_EQ(missing.blobErrors[0].code, 503);
  EXPECT_TRUE(missing.end);

  this->model->throws = false;
  EXPECT_EQ(client.Get(this->Blob(BlobId::Partition(0)))->status, 200u);
}

TEST_F(Server, ADiskThatHangsDelaysOnlyThoseWhoReadIt)
{
  this->options.threads = 1;
  this->options.readers = 3;
  const auto port = this->Start();
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);

  this->model->diskHangs = true;
  HttpTestClient reader(port);
  reader.Send("GET " + this->Blob(BlobId::Partition(0)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  stream.Ask({ 2, RegionRequest{ 1, 1, {} } });
  while (this->model->hanging != 2)
  {
    std::this_thread::yield();
  }
  HttpTestClient other(port);
  EXPECT_EQ(other.Get("/healthz")->body, "ok\n");
  EXPECT_EQ(other.Get("/api/models/dragon/model.json")->status, 200u);
  stream.Ask({ 2, CancelRequest{} });
  const auto cancelled = stream.Await(2);
  ASSERT_TRUE(cancelled.end);
  EXPECT_TRUE(cancelled.end->cancelled);
  const auto metrics = other.Get("/metrics")->body;
  EXPECT_NE(metrics.find("kdstream_reader_wait_seconds_count 3\n"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("kdstream_reader_queue 0\n"), std::string::npos);

  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  const auto blob = reader.Receive();
  ASSERT_TRUE(blob);
  EXPECT_EQ(blob->body.size(), this->model->blobs.at(BlobId::Partition(0))->size());
  stream.Ask({ 3, RegionRequest{ 64, 1, {} } });
  EXPECT_TRUE(this->IsRegion(stream.Await(3), 64, 1));
}

TEST_F(Server, StopsThoughReadersHaveWork)
{
  this->options.readers = 1;
  const auto port = this->Start();
  this->model->diskHangs = true;
  std::vector<std::unique_ptr<HttpTestClient>> readers;
  for (std::uint32_t p = 0; p < 3; ++p)
  {
    readers.push_back(std::make_unique<HttpTestClient>(port));
    readers.back()->Send(
      "GET " + this->Blob(BlobId::Partition(p)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  while (this->model->hanging != 1)
  {
    std::this_thread::yield();
  }
  std::thread stopping([this] { this->server->Stop(); });
  while (HttpTestClient::Connects(port))
  {
    std::this_thread::yield();
  }
  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  stopping.join();
}

TEST_F(Server, AnswersPipelinedRequestsInOrder)
{
  HttpTestClient client(this->Start());
  std::string burst;
  for (std::uint32_t p = 0; p < 50; ++p)
  {
    burst += "GET " + this->Blob(BlobId::Partition(p)) + " HTTP/1.1\r\nHost: x\r\n\r\n";
  }
  std::thread sender([&] { client.Send(burst); });
  for (std::uint32_t p = 0; p < 50; ++p)
  {
    const auto blob = client.Receive();
    ASSERT_TRUE(blob);
    EXPECT_EQ(blob->body.size(), this->model->blobs.at(BlobId::Partition(p))->size());
  }
  sender.join();
}

TEST_F(Server, ClosesWhenAskedTo)
{
  const auto port = this->Start();
  HttpTestClient client(port);
  EXPECT_EQ(client.Get("/healthz", "Connection: close\r\n")->status, 200u);
  EXPECT_TRUE(client.Ends());
  HttpTestClient old(port);
  old.Send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.Receive()->status, 200u);
  EXPECT_TRUE(old.Ends());
}

TEST_F(Server, RefusesWhatIsNotARequest)
{
  const auto port = this->Start();
  const auto statusOf = [port](const std::string& bytes) -> unsigned
  {
    HttpTestClient client(port);
    client.Send(bytes);
    const auto response = client.Receive();
    EXPECT_TRUE(client.Ends()) << bytes.substr(0, 40);
    return response ? response->status : 0;
  };
  EXPECT_EQ(statusOf("nonsense\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf(std::string("\x16\x03\x01\x02\x00\r\n\r\n", 9)), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/3.7\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\n\r\n"), 400u); // no host
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /a b HTTP/1.1\r\nHost: a\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nX y: b\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello"), 413u);
  EXPECT_EQ(
    statusOf(
      "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n"),
    413u);
  EXPECT_EQ(
    statusOf("GET / HTTP/1.1\r\nHost: a\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"), 431u);
  EXPECT_EQ(statusOf("GET /" + std::string(20000, 'x') + " HTTP/1.1\r\nHost: a\r\n\r\n"), 431u);
}

TEST_F(Server, SurvivesHostileBytes)
{
  this->options.requestTimeout = std::chrono::milliseconds(100); // some are no whole request
  const auto port = this->Start();
  RandomMessages random(13);
  const std::string good =
    "GET " + this->Blob(BlobId::Partition(1)) +
    " HTTP/1.1\r\nHost: a\r\nRange: bytes=1-5\r\nIf-None-Match: \"x\", W/\"y\"\r\n"
    "Connection: close\r\n\r\n";
  for (int i = 0; i < 300; ++i)
  {
    HttpTestClient client(port);
    client.Send(random.Mutated(good) + "\r\n\r\n");
    client.Receive();
  }
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->status, 200u);
}

TEST_F(Server, EndsConnectionsThatDoNotFinishTheirRequest)
{
  this->options.requestTimeout = std::chrono::milliseconds(100);
  const auto port = this->Start();
  HttpTestClient idle(port);
  HttpTestClient slow(port);
  std::atomic<bool> stop{ false };
  slow.Send("GET /healthz HTTP/1.1\r\nHost: a\r\n");
  std::thread dripping(
    [&]
    {
      while (!stop)
      {
        slow.Send("X: y\r\n");
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    });
  EXPECT_TRUE(idle.Ends());
  EXPECT_TRUE(slow.Ends());
  stop = true;
  dripping.join();
}

TEST_F(Server, RefusesMoreConnectionsThanItHasSeats)
{
  this->options.maximumConnections = 3;
  const auto port = this->Start();
  std::vector<std::unique_ptr<StreamTestClient>> seated;
  for (int i = 0; i < 3; ++i)
  {
    seated.push_back(std::make_unique<StreamTestClient>(port));
    EXPECT_TRUE(seated.back()->Open());
  }
  {
    HttpTestClient refused(port);
    const auto response = refused.Get("/healthz");
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 503u);
    EXPECT_TRUE(refused.Ends());
  }
  seated.pop_back();
  for (unsigned status = 503; status == 503;) // the server notices the free seat when it does
  {
    status = HttpTestClient(port).Get("/healthz")->status;
    EXPECT_TRUE(status == 503 || status == 200);
  }
}

TEST_F(Server, AnAddressHasSoManyConnections)
{
  this->options.connectionsOfAddress = 2;
  const auto port = this->Start();
  HttpTestClient first(port);
  auto second = std::make_unique<HttpTestClient>(port);
  EXPECT_EQ(first.Get("/healthz")->status, 200u);
  EXPECT_EQ(second->Get("/healthz")->status, 200u);
  {
    HttpTestClient third(port);
    const auto refused = third.Get("/healthz");
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 429u);
    EXPECT_EQ(refused->Field("Retry-After"), "1");
    EXPECT_TRUE(third.Ends());
  }
  EXPECT_TRUE(this->MetricsHave("kdstream_refusals_total{reason=\"address\"} 1\n", first));
  second.reset();
  for (unsigned status = 429; status == 429;) // the server notices the free seat when it does
  {
    status = HttpTestClient(port).Get("/healthz")->status;
    EXPECT_TRUE(status == 429 || status == 200);
  }
}

TEST_F(Server, AProxysClientsAreCountedByTheirOwnAddress)
{
  this->options.connectionsOfAddress = 1;
  this->options.requestsOfAddress = 3;
  this->options.trustedProxies = { "127.0.0.1" };
  const auto port = this->Start();
  const std::string upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                              "Sec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: kdstream.v1\r\nX-Forwarded-For: ";
  HttpTestClient first(port);
  HttpTestClient second(port);
  HttpTestClient third(port);
  EXPECT_EQ(first.Get("/api/stream", upgrade + "1.2.3.4\r\n")->status, 101u);
  EXPECT_EQ(second.Get("/api/stream", upgrade + "6.6.6.6, 1.2.3.4\r\n")->status, 429u);
  EXPECT_EQ(third.Get("/api/stream", upgrade + "1.2.3.5\r\n")->status, 101u);
  HttpTestClient pooled(port); // one connection of the proxy, for many
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.9\r\n")->status, 200u);
  }
  EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.9\r\n")->status, 429u);
  EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.10\r\n")->status, 200u);
  this->server->Stop();
  EXPECT_EQ(this->records.back().target, "/healthz");
  EXPECT_NE(std::find_if(this->records.begin(), this->records.end(),
              [](const AccessRecord& record) { return record.client == "1.2.3.10"; }),
    this->records.end());
}

TEST_F(Server, WhoAsksTooOftenIsToldAndStaysConnected)
{
  this->options.requestsOfAddress = 5;
  const auto port = this->Start();
  HttpTestClient client(port);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open()); // one
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  EXPECT_TRUE(stream.Await(1).opened);
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(client.Get("/healthz")->status, 200u);
  }
  const auto refused = client.Get("/healthz");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 429u);
  EXPECT_EQ(refused->Field("Retry-After"), "1");
  EXPECT_TRUE(client.Get("/healthz")) << "the connection stays";
  stream.Ask({ 2, PreviewRequest{} });
  const auto error = stream.Await(2).error;
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, 429);
}

TEST_F(Server, AnswersForTheHostsThatItIsTold)
{
  this->options.allowedHosts = { "models.example", "[::1]" };
  const auto port = this->Start();
  const auto statusFor = [port](const std::string& host, const std::string& target = "/")
  {
    HttpTestClient client(port);
    client.Send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    const auto response = client.Receive();
    return response ? response->status : 0;
  };
  EXPECT_EQ(statusFor("models.example"), 200u);
  EXPECT_EQ(statusFor("Models.Example:8700"), 200u);
  EXPECT_EQ(statusFor("[::1]:8700"), 200u);
  EXPECT_EQ(statusFor("[::1]"), 200u);
  for (const char* wrong :
    { "evil.example", "models.example.evil", "127.0.0.1", "", ":80", "]", "[::" })
  {
    EXPECT_EQ(statusFor(wrong), 421u) << wrong;
  }
  EXPECT_EQ(statusFor("10.0.0.7", "/healthz"), 200u);
}

TEST_F(Server, SeatsOfIdleConnectionsAreTakenBack)
{
  this->options.maximumConnections = 2;
  const auto port = this->Start();
  HttpTestClient longest(port);
  EXPECT_EQ(longest.Get("/healthz")->status, 200u);
  HttpTestClient idle(port);
  EXPECT_EQ(idle.Get("/healthz")->status, 200u);
  HttpTestClient next(port);
  EXPECT_EQ(next.Get("/healthz")->status, 200u);
  EXPECT_TRUE(longest.Ends());
  EXPECT_TRUE(this->MetricsHave("kdstream_refusals_total{reason=\"idle\"} 1\n", idle));
}

TEST_F(Server, SeatsOfIdleStreamsAreTakenBackButOfNoOthers)
{
  this->options.maximumConnections = 2;
  this->options.idleTimeout = std::chrono::milliseconds(0);
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  const auto port = this->Start();
  StreamTestClient busy(port);
  ASSERT_TRUE(busy.Open());
  busy.Ask({ 1, OpenRequest{ "dragon" } });
  busy.Await(1);
  busy.Ask({ 2, RegionRequest{ 1, 3, {} } }); // 64 MB, which nobody takes yet
  StreamTestClient idle(port);
  ASSERT_TRUE(idle.Open());
  idle.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(idle.Await(1).opened);
  unsigned status = 503;
  while (status == 503) // until the server knows that the client has its answer
  {
    status = HttpTestClient(port).Get("/healthz")->status;
  }
  EXPECT_EQ(status, 200u);
  EXPECT_FALSE(idle.Receive());
  EXPECT_EQ(idle.CloseCode(), 1001);
  EXPECT_TRUE(this->IsRegion(busy.Await(2), 1, 3));
}

TEST_F(Server, WhoTakesTooLittleIsDropped)
{
  this->options.answerTimeout = std::chrono::milliseconds(50);
  this->options.slowestBytes = std::size_t{ 1 } << 30;
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  const auto port = this->Start();
  StreamTestClient deaf(port);
  ASSERT_TRUE(deaf.Open());
  deaf.Ask({ 1, OpenRequest{ "dragon" } });
  deaf.Ask({ 2, RegionRequest{ 1, 3, {} } });
  HttpTestClient slow(port);
  for (std::uint32_t p = 0; p < 60; ++p)
  {
    slow.Send("GET " + this->Blob(BlobId::Partition(p)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  HttpTestClient other(port);
  while (!this->MetricsHave("kdstream_refusals_total{reason=\"slow\"} 2\n", other))
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(this->MetricsHave("kdstream_streams 0\n", other));
}

TEST_F(Server, UpgradesOnlyWhatItKnows)
{
  const auto port = this->Start();
  StreamTestClient good(port);
  EXPECT_TRUE(good.Open());
  EXPECT_EQ(good.Subprotocol(), "kdstream.v1");
  const auto statusOf = [port](const std::string& target, const std::string& fields)
  {
    const auto response = HttpTestClient(port).Get(
      target, "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                fields);
    return response ? response->status : 0;
  };
  const std::string protocol = "Sec-WebSocket-Protocol: ";
  const std::string ours = protocol + "kdstream.v1\r\n";
  EXPECT_EQ(statusOf("/api/stream", ours), 101u);
  EXPECT_EQ(statusOf("/api/stream?x", ours), 101u);
  EXPECT_EQ(statusOf("/api/stream", protocol + "other, kdstream.v1\r\n"), 101u);
  EXPECT_EQ(statusOf("/api/stream", ""), 400u);
  EXPECT_EQ(statusOf("/api/stream", protocol + "kdstream.v2\r\n"), 400u);
  EXPECT_EQ(statusOf("/api/streams", ours), 404u);
  EXPECT_EQ(statusOf("/", ours), 404u);
  EXPECT_EQ(statusOf("/api/stream", ours + "Origin: https://example.org\r\n"), 403u);
  EXPECT_EQ(statusOf("/api/stream", ours + "Origin: http://test\r\n"), 101u); // the client's Host
}

TEST_F(Server, FiftyClientsAtOnceGetTheirRegions)
{
  const auto port = this->Start();
  constexpr int clients = 50;
  std::atomic<int> good{ 0 };
  std::atomic<int> connected{ 0 };
  std::vector<std::thread> threads;
  for (int i = 0; i < clients; ++i)
  {
    threads.emplace_back(
      [&, i]
      {
        StreamTestClient client(port);
        const bool open = client.Open();
        ++connected;
        while (connected < clients) // all at once
        {
          std::this_thread::yield();
        }
        client.Ask({ 1, OpenRequest{ "dragon" } });
        const auto opened = client.Await(1);
        const auto cell = static_cast<std::uint32_t>(128 + i * 2);
        const auto rings = static_cast<std::uint8_t>(1 + i % 3);
        client.Ask({ 2, RegionRequest{ cell, rings, {} } });
        const auto region = client.Await(2);
        if (open && opened.opened && opened.opened->model == this->model->Description() &&
            this->IsRegion(region, cell, rings) &&
            region.begin->partitions == this->Region(cell, rings))
        {
          ++good;
        }
        client.Close();
      });
  }
  for (auto& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(good.load(), clients);
}

TEST_F(Server, CancelStopsTheStream)
{
  // 64 MB, much more than the sockets hold.
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  StreamTestClient client(this->Start());
  ASSERT_TRUE(client.Open());
  client.Ask({ 1, OpenRequest{ "dragon" } });
  client.Await(1);
  client.Ask({ 2, RegionRequest{ 1, 1, {} } });
  const auto answer = client.Await(2,
    [&](std::size_t frames)
    {
      if (frames == 3)
      {
        client.Ask({ 2, CancelRequest{} });
      }
    });
  ASSERT_TRUE(answer.end);
  EXPECT_TRUE(answer.end->cancelled);
  EXPECT_LT(answer.end->blobs, 32u);
  EXPECT_EQ(answer.end->blobs, answer.blobs.size());
  EXPECT_EQ(this->model->reads.load(), answer.blobs.size() + (answer.end->bytes > 0 ? 1 : 0));
  client.Ask({ 3, PreviewRequest{} });
  EXPECT_EQ(client.Await(3).blobs.size(), 1u);
}

TEST_F(Server, AClientThatNeverReadsStopsNobody)
{
  this->options.threads = 1;
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  const auto port = this->Start();
  std::vector<std::unique_ptr<StreamTestClient>> silent;
  for (int i = 0; i < 5; ++i)
  {
    silent.push_back(std::make_unique<StreamTestClient>(port));
    ASSERT_TRUE(silent.back()->Open());
    silent.back()->Ask({ 1, OpenRequest{ "dragon" } });
    silent.back()->Ask({ 2, RegionRequest{ 1, 3, {} } });
  }
  HttpTestClient deaf(port); // asks for many blobs and takes none
  for (std::uint32_t p = 0; p < 60; ++p)
  {
    deaf.Send("GET " + this->Blob(BlobId::Partition(p)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  for (int i = 0; i < 3; ++i)
  {
    StreamTestClient client(port);
    ASSERT_TRUE(client.Open());
    client.Ask({ 1, OpenRequest{ "dragon" } });
    client.Await(1);
    client.Ask({ 2, RegionRequest{ 64, 1, {} } });
    EXPECT_TRUE(this->IsRegion(client.Await(2), 64, 1));
  }
  EXPECT_LT(this->model->reads.load(), 6u * 64u) << "nothing is read ahead for those who do not";
}

TEST_F(Server, DamagedBlobsAreNamedAndTheRestComes)
{
  this->model->damaged = { BlobId::Partition(3) };
  const auto port = this->Start();
  EXPECT_EQ(HttpTestClient(port).Get(this->Blob(BlobId::Partition(3)))->status, 500u);
  StreamTestClient client(port);
  ASSERT_TRUE(client.Open());
  client.Ask({ 1, OpenRequest{ "dragon" } });
  client.Await(1);
  client.Ask({ 2, RegionRequest{ 1, 0, {} } });
  const auto answer = client.Await(2);
  EXPECT_EQ(answer.blobs.size(), 127u);
  ASSERT_EQ(answer.blobErrors.size(), 1u);
  EXPECT_EQ(answer.blobErrors[0].blob, BlobId::Partition(3));
  const auto metrics = HttpTestClient(port).Get("/metrics")->body;
  EXPECT_NE(metrics.find("kdstream_failed_blobs_total 2\n"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("kdstream_streams 1\n"), std::string::npos) << metrics;
}

TEST_F(Server, ConversationsThatCannotGoOnAreClosedWithTheirReason)
{
  const auto port = this->Start();
  const auto closeCode = [port](const std::function<void(StreamTestClient&)>& misbehave)
  {
    StreamTestClient client(port);
    EXPECT_TRUE(client.Open());
    misbehave(client);
    while (client.Receive())
    {
    }
    return client.CloseCode();
  };
  EXPECT_EQ(closeCode([](auto& client) { client.SendText("nonsense"); }), 1007);
  EXPECT_EQ(closeCode([](auto& client) { client.SendText(std::string(5000, ' ')); }), 1009);
  // Far too large: the server does not read to the end, so that the reason may be lost on its way.
  EXPECT_NE(closeCode([](auto& client) { client.SendText(std::string(500000, ' ')); }), 1000);
  EXPECT_EQ(closeCode([](auto& client) { client.SendBinary("x"); }), 1003);
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->status, 200u);
}

TEST_F(Server, HostileMessagesEndTheirOwnStreamOnly)
{
  const auto port = this->Start();
  RandomMessages random(14);
  for (int i = 0; i < 100; ++i)
  {
    StreamTestClient client(port);
    ASSERT_TRUE(client.Open());
    for (int n = 0; n < 5; ++n)
    {
      auto text = WriteClientMessage(random.FromClient());
      client.SendText(n == 4 ? random.Mutated(text) : text);
    }
  }
  StreamTestClient client(port);
  ASSERT_TRUE(client.Open());
  client.Ask({ 1, OpenRequest{ "dragon" } });
  EXPECT_TRUE(client.Await(1).opened);
}

TEST_F(Server, StoppingFinishesWhatIsUnderWay)
{
  this->options.drainTimeout = std::chrono::seconds(60);
  const auto port = this->Start();
  HttpTestClient idle(port);
  EXPECT_EQ(idle.Get("/healthz")->status, 200u);
  StreamTestClient quiet(port);
  ASSERT_TRUE(quiet.Open());
  StreamTestClient client(port);
  ASSERT_TRUE(client.Open());
  client.Ask({ 1, OpenRequest{ "dragon" } });
  client.Await(1);
  client.Ask({ 2, RegionRequest{ 1, 3, {} } });
  std::thread stopping;
  const auto answer = client.Await(2,
    [&](std::size_t frames)
    {
      if (frames == 2)
      {
        stopping = std::thread([&] { this->server->Stop(); });
      }
    });
  EXPECT_TRUE(this->IsRegion(answer, 1, 3));
  EXPECT_FALSE(client.Receive());
  EXPECT_EQ(client.CloseCode(), 1001);
  EXPECT_FALSE(quiet.Receive());
  EXPECT_EQ(quiet.CloseCode(), 1001);
  EXPECT_TRUE(idle.Ends());
  stopping.join();
}

TEST_F(Server, StopsAlsoWithClientsThatDoNotRead)
{
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  const auto port = this->Start();
  StreamTestClient silent(port);
  ASSERT_TRUE(silent.Open());
  silent.Ask({ 1, OpenRequest{ "dragon" } });
  silent.Ask({ 2, RegionRequest{ 1, 3, {} } });
  this->server->Stop();
  this->server->Stop(); // again does nothing
  EXPECT_FALSE(HttpTestClient::Connects(port));
}

TEST_F(Server, TellsWhyItCannotStart)
{
  const auto port = this->Start();
  HttpServerOptions taken;
  taken.port = port;
  const auto second = HttpServer::Start(this->catalog, taken);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.GetError().code, ErrorCode::InputOutput);
  HttpServerOptions nowhere;
  nowhere.host = "no address at all";
  EXPECT_FALSE(HttpServer::Start(this->catalog, nowhere));
  HttpServerOptions secret;
  secret.tlsCertificate = "/nonexistent/cert.pem";
  secret.tlsKey = "/nonexistent/key.pem";
  EXPECT_FALSE(HttpServer::Start(this->catalog, secret));
}
