// SPDX-License-Identifier: BSD-3-Clause
// A slot becomes free when its client has left or its time is over, even if a disk hangs, a client
// continues to send, or a timer is lost.
#include "Testing/Fixtures/Eventually.h"
#include "server/http/ServerState.h"
#include "server/http/Testing/ClientFrames.h"
#include "server/http/Testing/RawSocket.h"
#include "server/http/Testing/ServerTest.h"

#include <atomic>

using namespace kdstream;

namespace
{

using namespace std::chrono_literals;

class ConnectionSlots : public ServerTest
{
protected:
  void SetUp() override
  {
    this->options.answerTimeout = 300ms;
    this->options.requestTimeout = 300ms;
    this->options.admin = ListenAddress{};
  }

  bool AwaitMetric(const std::string& line)
  {
    HttpTestClient first(this->AdminPort());
    return fixtures::Eventually(
      [&]
      {
        HttpTestClient admin(this->AdminPort());
        return this->MetricsHave(line + "\n", admin);
      });
  }
  void EndHanging()
  {
    this->model->diskHangs = false;
    this->model->diskHangs.notify_all();
  }
  std::string GetBlob() const
  {
    return "GET " + this->Blob(protocol::BlobId::Partition(3)) + " HTTP/1.1\r\nHost: x\r\n\r\n";
  }
};

// A connection whose timers do not work.
class Forgetful final : public Drainable
{
public:
  explicit Forgetful(Clock::duration left) { this->EndBy(Clock::now() + left); }
  void Drain() override {}
  void GiveUp() override {}
  void EndIfOverdue() override { ++this->ended; }
  int ended = 0;
};

}

TEST_F(ConnectionSlots, AStreamsIsFreeThoughADiskHangs)
{
  const auto port = this->Start();
  this->model->diskHangs = true;
  {
    RawSocket client(port);
    client.Send(UpgradeRequest());
    std::string answer;
    ASSERT_TRUE(client.ReceiveUntil("\r\n\r\n", answer, RawSocket::patience));
    client.Send(TextFrame(R"({"type":"open","request":1,"model":"dragon"})"));
    ASSERT_TRUE(client.ReceiveUntil("opened", answer, RawSocket::patience));
    client.Send(TextFrame(R"({"type":"blobs","request":2,"blobs":["partitions/3"]})"));
    ASSERT_TRUE(fixtures::Eventually([this] { return this->model->hanging > 0; }));
    EXPECT_TRUE(this->AwaitMetric("kdstream_streams 1"));
  }
  EXPECT_TRUE(this->AwaitMetric("kdstream_streams 0"));
  EXPECT_TRUE(this->AwaitMetric("kdstream_connections 0"));
  this->EndHanging();
}

TEST_F(ConnectionSlots, ARequestsIsFreeWhenItsClientIsReset)
{
  this->options.answerTimeout = 10min;
  const auto port = this->Start();
  this->model->diskHangs = true;
  RawSocket client(port);
  client.Send(this->GetBlob());
  ASSERT_TRUE(fixtures::Eventually([this] { return this->model->hanging > 0; }));
  EXPECT_TRUE(this->AwaitMetric("kdstream_connections 1"));
  client.Reset();
  EXPECT_TRUE(this->AwaitMetric("kdstream_connections 0"));
  this->EndHanging();
}

// If making a tileset takes too long, this is not reported as a disk's failure.
TEST_F(ConnectionSlots, WhatTakesLongToMakeIsAskedForAgain)
{
  const auto port = this->Start();
  this->model->diskHangs = true;
  const auto answer = HttpTestClient(port).Get("/api/models/dragon/3dtiles/tileset.json");
  EXPECT_EQ(answer->status, 503U);
  EXPECT_NE(answer->body.find("this takes long to make: try again"), std::string::npos)
    << answer->body;
  EXPECT_TRUE(this->AwaitMetric("kdstream_failures_total{what=\"disk\"} 0"));
  this->EndHanging();
}

// A client that has only closed its sending side may wait for an answer, but not forever.
TEST_F(ConnectionSlots, AReaderIsWaitedForOnlyForALimitedTime)
{
  const auto port = this->Start();
  this->model->diskHangs = true;
  RawSocket client(port);
  client.Send(this->GetBlob());
  client.EndOutput();
  std::string answer;
  ASSERT_TRUE(client.ReceiveUntil("}\n", answer, RawSocket::patience));
  EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 503") << answer;
  EXPECT_NE(answer.find("the disk does not respond: try again"), std::string::npos) << answer;
  EXPECT_TRUE(client.AwaitEnd(RawSocket::patience));
  EXPECT_TRUE(this->AwaitMetric("kdstream_connections 0"));
  this->EndHanging();
  // Reading works again once the disk answers; until then the client is asked to retry.
  EXPECT_TRUE(fixtures::Eventually(
    [&] {
      return HttpTestClient(port).Get(this->Blob(protocol::BlobId::Partition(3)))->status == 200;
    }));
}

// The socket's timers do not expire while there is always something to read.
TEST_F(ConnectionSlots, WhoSendsOnAndOnAfterTheEndKeepsNone)
{
  const auto port = this->Start();
  std::atomic<bool> stop{ false };
  std::vector<std::thread> threads;
  for (const auto& begin :
    { std::string("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\n"), UpgradeRequest() })
  {
    threads.emplace_back(
      [&stop, begin, port]
      {
        RawSocket client(port);
        client.Send(begin);
        std::string answer;
        client.ReceiveUntil("\r\n\r\n", answer, RawSocket::patience);
        client.Send(CloseFrame(1000)); // this ends a stream
        const std::string noise(65536, 'x');
        while (!stop && client.Send(noise, 1000ms))
        {
        }
      });
  }
  EXPECT_TRUE(this->AwaitMetric("kdstream_streams_total 1"));
  EXPECT_TRUE(this->AwaitMetric("kdstream_connections 0"));
  stop = true;
  for (auto& thread : threads)
  {
    thread.join();
  }
}

TEST_F(ConnectionSlots, AreTakenBackFromConnectionsWhoseTimersFail)
{
  ServerState state(this->catalog, this->options);
  const auto good = std::make_shared<Forgetful>(1h), bad = std::make_shared<Forgetful>(-1h);
  state.Enter(good);
  state.Enter(bad);
  state.EndOverdue();
  EXPECT_EQ(good->ended, 0);
  EXPECT_EQ(bad->ended, 1);
  state.EndOverdue();
  EXPECT_EQ(bad->ended, 2) << "until it has gone";
  state.Leave(good.get());
  state.Leave(bad.get());
}
