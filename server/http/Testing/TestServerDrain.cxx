// SPDX-License-Identifier: BSD-3-Clause
// How a server ends: requests in flight are finished, and new ones are refused with the reason.
#include "Testing/Fixtures/Eventually.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/Testing/ServerTest.h"

#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Drain = ServerTest;

}

TEST_F(Drain, StopsThoughReadersHaveWork)
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
  EXPECT_TRUE(fixtures::Eventually([&] { return this->model->hanging == 1; }));
  std::thread stopping([this] { this->server->Stop(); });
  EXPECT_TRUE(
    fixtures::Eventually([&] { return HttpTestClient(port).Get("/readyz")->status != 200; }));
  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  stopping.join();
}

TEST_F(Drain, StoppingFinishesWhatIsInFlight)
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

TEST_F(Drain, WhatIsNewIsRefusedWhileAnswersAreFinished)
{
  const auto port = this->Start();
  EXPECT_EQ(HttpTestClient(port).Get("/readyz")->body, "ready\n");
  HttpTestClient reader(port);
  this->model->diskHangs = true;
  reader.Send("GET " + this->Blob(BlobId::Partition(0)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(fixtures::Eventually([&] { return this->model->hanging == 1; }));
  HttpTestClient idle(port);
  EXPECT_EQ(idle.Get("/healthz")->status, 200u);

  this->server->BeginDrain();
  EXPECT_TRUE(idle.Ends());
  for (const char* path : { "/api/models.json", "/", "/metrics", "/api/stream", "/readyz" })
  {
    HttpTestClient late(port);
    const auto refused = late.Get(path);
    ASSERT_TRUE(refused) << path;
    EXPECT_EQ(refused->status, 503u) << path;
    EXPECT_EQ(refused->Field("Retry-After"), "1");
    EXPECT_NE(refused->body.find("the server is stopping"), std::string::npos) << refused->body;
    EXPECT_TRUE(late.Ends());
  }
  EXPECT_FALSE(StreamTestClient(port).Open());
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->body, "ok\n") << "it is alive";
  EXPECT_FALSE(this->server->WaitUntilDrained(std::chrono::milliseconds(0)));

  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  const auto blob = reader.Receive();
  ASSERT_TRUE(blob);
  EXPECT_EQ(blob->status, 200u);
  EXPECT_EQ(blob->body.size(), this->model->blobs.at(BlobId::Partition(0))->size());
  EXPECT_TRUE(reader.Ends());
  EXPECT_TRUE(this->server->WaitUntilDrained(std::chrono::minutes(10)));
}

TEST_F(Drain, AStreamFinishesItsRequestAndTakesNoOther)
{
  const auto port = this->Start();
  StreamTestClient client(port);
  ASSERT_TRUE(client.Open());
  client.Ask({ 1, OpenRequest{ "dragon" } });
  client.Await(1);
  this->model->diskHangs = true;
  client.Ask({ 2, RegionRequest{ 1, 3, {} } });
  EXPECT_TRUE(fixtures::Eventually([&] { return this->model->hanging == 1; }));
  this->server->BeginDrain();
  client.Ask({ 3, AskPieces(0, { 1 }) });
  const auto refused = client.Await(3);
  ASSERT_TRUE(refused.error);
  EXPECT_EQ(refused.error->code, 503);
  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  EXPECT_TRUE(this->IsRegion(client.Await(2), 1, 3));
  EXPECT_FALSE(client.Receive());
  EXPECT_EQ(client.CloseCode(), 1001);
  EXPECT_TRUE(this->server->WaitUntilDrained(std::chrono::minutes(10)));
}

TEST_F(Drain, StopsAlsoWithClientsThatDoNotRead)
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
