// SPDX-License-Identifier: BSD-3-Clause
// Which clients are admitted, how much each may have, and which ones have to leave.
#include "Testing/Fixtures/Eventually.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/Testing/ServerTest.h"

#include <atomic>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Limits = ServerTest;

}

TEST_F(Limits, EndsConnectionsThatDoNotFinishTheirRequest)
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

TEST_F(Limits, RefusesMoreConnectionsThanItHasSlots)
{
  this->options.maximumConnections = 3;
  const auto port = this->Start();
  std::vector<std::unique_ptr<StreamTestClient>> connected;
  for (int i = 0; i < 3; ++i)
  {
    connected.push_back(std::make_unique<StreamTestClient>(port));
    EXPECT_TRUE(connected.back()->Open());
  }
  {
    HttpTestClient refused(port);
    const auto response = refused.Get("/healthz");
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 503u);
    EXPECT_TRUE(refused.Ends());
  }
  connected.pop_back();
  for (unsigned status = 503; status == 503;) // until the server notices the free slot
  {
    status = HttpTestClient(port).Get("/healthz")->status;
    EXPECT_TRUE(status == 503 || status == 200);
  }
}

TEST_F(Limits, AHeaderHasALimitedSize)
{
  this->options.headerBytes = 1024;
  HttpTestClient client(this->Start());
  EXPECT_EQ(client.Get("/healthz", "X: " + std::string(900, 'x') + "\r\n")->status, 200u);
  const auto refused = client.Get("/healthz", "X: " + std::string(1024, 'x') + "\r\n");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 431u);
  EXPECT_NE(refused->body.find("1024 bytes"), std::string::npos);
  EXPECT_TRUE(client.Ends());
}

TEST_F(Limits, AnAddressHasALimitedNumberOfConnections)
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
  for (unsigned status = 429; status == 429;) // until the server notices the free slot
  {
    status = HttpTestClient(port).Get("/healthz")->status;
    EXPECT_TRUE(status == 429 || status == 200);
  }
}

TEST_F(Limits, WhoAsksTooOftenGetsAnErrorAndStaysConnected)
{
  this->options.requestsOfAddress = 5;
  const auto port = this->Start();
  HttpTestClient client(port);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open()); // one request
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  EXPECT_TRUE(stream.Await(1).opened);
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(client.Get("/healthz")->status, 200u);
  }
  const auto refused = client.Get("/healthz");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 429u);
  const auto seconds = refused->Field("Retry-After"); // one becomes available every 12 s
  EXPECT_TRUE(seconds == "12" || seconds == "11") << seconds;
  EXPECT_EQ(refused->body, "{\"error\":\"too many requests: try again in " + seconds + " s\"}\n");
  EXPECT_TRUE(client.Get("/healthz")) << "the connection stays";
  stream.Ask({ 2, AskPieces(0, { 1 }) });
  const auto error = stream.Await(2).error;
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, 429);
}

TEST_F(Limits, SlotsOfIdleConnectionsAreTakenBack)
{
  this->options.maximumConnections = 2;
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  HttpTestClient admin(this->AdminPort());
  int answers = 0;
  const auto ask = [&](HttpTestClient& client)
  {
    EXPECT_EQ(client.Get("/healthz")->status, 200u);
    const auto line = "{status=\"200\"} " + std::to_string(++answers) + "\n";
    // Wait until the server knows that the client has its answer.
    EXPECT_TRUE(fixtures::Eventually([&] { return this->MetricsHave(line, admin); }));
  };
  HttpTestClient longest(port);
  ask(longest);
  HttpTestClient idle(port);
  ask(idle);
  HttpTestClient next(port);
  ask(next);
  EXPECT_TRUE(longest.Ends());
  EXPECT_TRUE(this->MetricsHave("kdstream_refusals_total{reason=\"idle\"} 1\n", admin));
  ask(idle);
}

TEST_F(Limits, SlotsOfIdleStreamsAreTakenBackButOfNoOthers)
{
  this->options.maximumConnections = 2;
  this->options.idleTimeout = std::chrono::milliseconds(0);
  this->model = this->catalog.Add("dragon", 2, 6, 1000000);
  const auto port = this->Start();
  StreamTestClient busy(port);
  ASSERT_TRUE(busy.Open());
  busy.Ask({ 1, OpenRequest{ "dragon" } });
  busy.Await(1);
  busy.Ask({ 2, RegionRequest{ 1, 3, {} } }); // 64 MB, which nobody reads yet
  StreamTestClient idle(port);
  ASSERT_TRUE(idle.Open());
  idle.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(idle.Await(1).opened);
  unsigned status = 503;
  // Wait until the server knows that the client has its answer.
  EXPECT_TRUE(fixtures::Eventually(
    [&]
    {
      status = HttpTestClient(port).Get("/healthz")->status;
      return status != 503;
    }));
  EXPECT_EQ(status, 200u);
  EXPECT_FALSE(idle.Receive());
  EXPECT_EQ(idle.CloseCode(), 1001);
  EXPECT_TRUE(this->IsRegion(busy.Await(2), 1, 3));
}

TEST_F(Limits, WhoTakesTooLittleIsDropped)
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
  EXPECT_TRUE(fixtures::Eventually(
    [&]
    {
      return this->MetricsHave("kdstream_refusals_total{reason=\"slow\"} 2\n", other) &&
             this->MetricsHave("kdstream_streams 0\n", other);
    }));
}

// A client that reads nothing is dropped soon, although its whole answer may take ten minutes here.
TEST_F(Limits, WhoTakesNothingAtAllIsDroppedSoon)
{
  this->options.answerTimeout = std::chrono::milliseconds(50);
  this->options.slowestBytes = std::size_t{ 64 } << 10;
  this->model = this->catalog.Add("dragon", 2, 1, 40'000'000);
  const auto port = this->Start();
  HttpTestClient deaf(port);
  deaf.Send("GET " + this->Blob(BlobId::Partition(1)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  HttpTestClient other(port);
  EXPECT_TRUE(fixtures::Eventually(
    [&] { return this->MetricsHave("kdstream_refusals_total{reason=\"slow\"} 1\n", other); }));
  // The bytes that went into the system's buffers are logged and counted.
  const auto& whole = *this->model->blobs.at(BlobId::Partition(1));
  const auto logged = this->AwaitRecord(this->Blob(BlobId::Partition(1))).bytes;
  EXPECT_GE(logged, 4096u);
  EXPECT_LT(logged, whole.size());
  // A client that reads is sent all of it.
  const auto blob = other.Get(this->Blob(BlobId::Partition(1)));
  ASSERT_TRUE(blob);
  EXPECT_EQ(blob->body, std::string(whole.begin(), whole.end()));
  EXPECT_EQ(other.Get("/healthz")->status, 200u);
}
