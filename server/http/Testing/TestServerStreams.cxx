// SPDX-License-Identifier: BSD-3-Clause
// Streams on real sockets: behaviour that the conversation cannot show by itself.
#include "Testing/Fixtures/Eventually.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/Testing/ServerTest.h"

#include <atomic>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Streams = ServerTest;

}

TEST_F(Streams, UpgradesOnlyWhatItKnows)
{
  const auto port = this->Start();
  StreamTestClient good(port);
  EXPECT_TRUE(good.Open());
  EXPECT_EQ(good.Subprotocol(), "kdstream.v2");
  const auto statusOf = [port](const std::string& target, const std::string& fields)
  {
    const auto response = HttpTestClient(port).Get(
      target, "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                fields);
    return response ? response->status : 0;
  };
  const std::string protocol = "Sec-WebSocket-Protocol: ";
  const std::string ours = protocol + "kdstream.v2\r\n";
  EXPECT_EQ(statusOf("/api/stream", ours), 101u);
  EXPECT_EQ(statusOf("/api/stream?x", ours), 101u);
  EXPECT_EQ(statusOf("/api/stream", protocol + "other, kdstream.v2\r\n"), 101u);
  EXPECT_EQ(statusOf("/api/stream", ""), 400u);
  EXPECT_EQ(statusOf("/api/stream", protocol + "kdstream.v1\r\n"), 400u);
  EXPECT_EQ(statusOf("/api/streams", ours), 404u);
  EXPECT_EQ(statusOf("/", ours), 404u);
  EXPECT_EQ(statusOf("/api/stream", ours + "Origin: https://example.org\r\n"), 403u);
  HttpTestClient watcher(port);
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"origin\"} 1\n", watcher));
  EXPECT_EQ(statusOf("/api/stream", ours + "Origin: http://test\r\n"), 101u); // the client's Host
}

TEST_F(Streams, FiftyClientsAtOnceGetTheirRegions)
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
        // wait, so that all clients ask at once
        EXPECT_TRUE(fixtures::Eventually([&] { return connected >= clients; }));
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

TEST_F(Streams, CancelStopsTheStream)
{
  // 64 MB: much more than the buffers of sockets hold.
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
  client.Ask({ 3, AskPieces(0, { 1 }) });
  EXPECT_EQ(client.Await(3).blobs.size(), 1u);
}

TEST_F(Streams, AClientThatNeverReadsStopsNobody)
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
  HttpTestClient deaf(port); // requests many blobs and reads none
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

TEST_F(Streams, DamagedBlobsAreNamedAndTheRestComes)
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

TEST_F(Streams, ConversationsThatCannotGoOnAreClosedWithTheirReason)
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
  // The message is far too large. The server does not read it to its end, so the reason may not
  // arrive.
  EXPECT_NE(closeCode([](auto& client) { client.SendText(std::string(500000, ' ')); }), 1000);
  EXPECT_EQ(closeCode([](auto& client) { client.SendBinary("x"); }), 1003);
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->status, 200u);
}

TEST_F(Streams, HostileMessagesEndTheirOwnStreamOnly)
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
