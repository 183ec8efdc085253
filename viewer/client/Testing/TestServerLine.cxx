// SPDX-License-Identifier: BSD-3-Clause
// When a ServerLine connects, sends, fetches, waits and gives up, without sockets and clocks.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/client/ServerLine.h"

#include "filters/model/ModelJson.h"
#include "viewer/client/Testing/SessionRequests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

using namespace kdstream;
using namespace kdstream::testing;
using ActionKind = ServerLine::Action::Kind;
using State = ServerLine::State;
using EventKind = ClientEvent::Kind;
using protocol::BlobId;

namespace
{

ModelDescription Model()
{
  ModelDescription model;
  model.id = "m";
  model.digest = std::string(32, 'a');
  model.vertices = 1;
  model.box = { { 0, 0, 0 }, { 1, 1, 1 } };
  model.levels.resize(1);
  return model;
}

// The actions as texts: "connect", "close", "fetch PATH", or the message that is sent, such as
// "open m" or "partitions 1 2".
std::vector<std::string> Actions(ServerLine& line)
{
  std::vector<std::string> names;
  for (const ServerLine::Action& action : line.TakeActions())
  {
    switch (action.kind)
    {
      case ActionKind::Connect:
        names.push_back("connect");
        break;
      case ActionKind::Close:
        names.push_back("close");
        break;
      case ActionKind::Fetch:
        names.push_back("fetch " + action.fetch.target);
        break;
      case ActionKind::Send:
      {
        const auto message = protocol::ParseClientMessage(action.text);
        EXPECT_TRUE(message) << action.text;
        if (const auto* open = std::get_if<protocol::OpenRequest>(&message->body))
        {
          names.push_back("open " + open->model);
        }
        else if (const auto* list = std::get_if<protocol::BlobsRequest>(&message->body))
        {
          names.push_back("partitions");
          for (const BlobId& partition : list->blobs)
          {
            names.back() += " " + std::to_string(partition.number);
          }
        }
        else
        {
          names.push_back(action.text);
        }
        break;
      }
    }
  }
  return names;
}
using Names = std::vector<std::string>;

void SendOpened(ServerLine& line, std::uint32_t wire, double now)
{
  line.SocketText(protocol::WriteServerMessage({ wire, protocol::OpenedAnswer{ Model() } }), now);
}

void SendPartition(ServerLine& line, std::uint32_t wire, std::uint32_t partition, double now)
{
  const std::vector<std::uint8_t> payload{ 1, 2, 3 };
  line.SocketFrame(
    protocol::EncodeFrame({ wire, BlobId::Partition(partition), 0, 3 }, payload), now);
}

ServerLineOptions Patient()
{
  ServerLineOptions options;
  options.authority = "server:1";
  options.patient = true;
  options.firstRetry = 1;
  options.longestRetry = 5;
  return options;
}

// A line that streams, with model m open and partitions 1 and 2 outstanding in message 2.
void Stream(ServerLine& line, double now)
{
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.Send(OpenModel(1), now);
  EXPECT_EQ(Actions(line), Names{}); // sent only when there is a connection
  line.SocketOpened(now);
  EXPECT_EQ(Actions(line), Names{ "open m" });
  SendOpened(line, 2, now); // number 2: message 1 was lost, without a connection
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::Opened);
  line.Send(Partitions(2, { BlobId::Partition(1), BlobId::Partition(2) }), now);
  EXPECT_EQ(Actions(line), Names{ "partitions 1 2" });
  EXPECT_EQ(line.GetState(), State::Streaming);
  EXPECT_EQ(line.Trouble(), "");
}

TEST(TestServerLine, APatientLineTriesForAsLongAsItTakesAndAsksAgainForWhatIsOutstanding)
{
  ServerLine line(Patient());
  Stream(line, 0);
  SendPartition(line, 3, 1, 1);
  EXPECT_EQ(line.TakeEvents().size(), 1u);

  // After a loss it connects again at once, and then after 1, 2, 4, 5, 5 … seconds.
  line.SocketEnded(false, "reset", 10);
  EXPECT_EQ(line.GetState(), State::Connecting);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  double now = 10;
  for (const double wait : { 1.0, 2.0, 4.0, 5.0, 5.0 })
  {
    line.SocketEnded(false, "refused", now);
    EXPECT_EQ(line.GetState(), State::Lost);
    EXPECT_TRUE(fixtures::Mentions(line.Trouble(), { "server:1 ", "refused" }));
    EXPECT_EQ(Actions(line), Names{ "close" });
    line.Tick(now + wait - 0.01);
    EXPECT_EQ(Actions(line), Names{});
    line.Tick(now + wait);
    EXPECT_EQ(Actions(line), Names{ "connect" }) << wait;
    now += wait;
  }
  EXPECT_TRUE(line.TakeEvents().empty()); // nothing has failed

  line.SocketOpened(now);
  EXPECT_EQ(line.Trouble(), "");
  EXPECT_EQ(Actions(line), (Names{ "open m", "partitions 2" }));

  // After something has arrived, it connects again at once after a loss, and the pauses begin again
  // at 1 s.
  SendOpened(line, 4, now);
  line.SocketEnded(false, "reset", now);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketEnded(false, "reset", now);
  EXPECT_EQ(Actions(line), Names{ "close" });
  line.Tick(now + 1);
  EXPECT_EQ(Actions(line), Names{ "connect" });
}

namespace
{

// Makes the line stream, with model m open and no outstanding requests.
void StreamAtRest(ServerLine& line)
{
  Stream(line, 0);
  SendPartition(line, 3, 1, 1);
  SendPartition(line, 3, 2, 1);
  line.SocketText(protocol::WriteServerMessage({ 3, protocol::EndAnswer{ 2, 6, 0, false } }), 1);
  EXPECT_EQ(line.TakeEvents().size(), 2u);
}

}

// This matters when a server restarts, which ends all connections at the same moment.
TEST(TestServerLine, WhoWaitsForNothingComesBackLaterOrWhenSomethingIsAskedFor)
{
  for (const bool patient : { true, false })
  {
    auto options = Patient();
    options.patient = patient;
    ServerLine line(options);
    StreamAtRest(line);
    line.SocketEnded(false, "going away", 10);
    EXPECT_EQ(Actions(line), Names{ "close" }) << "not at once";
    EXPECT_EQ(line.GetState(), State::Lost);
    EXPECT_EQ(line.Trouble(), "") << "nobody is kept waiting";
    EXPECT_EQ(line.NextTick(), patient ? 12 : std::numeric_limits<double>::infinity());
    line.Send(Partitions(3, { BlobId::Partition(7) }), 11);
    EXPECT_EQ(Actions(line), Names{ "connect" });
    line.SocketOpened(11);
    EXPECT_EQ(Actions(line), (Names{ "open m", "partitions 7" }));
  }
}

TEST(TestServerLine, AFailedRetryIsReported)
{
  ServerLine line(Patient());
  StreamAtRest(line);
  line.SocketEnded(false, "going away", 10);
  Actions(line);
  line.Tick(12);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketEnded(false, "refused", 12);
  EXPECT_EQ(line.GetState(), State::Lost);
  EXPECT_TRUE(fixtures::Mentions(line.Trouble(), { "server:1 ", "refused" }));
  EXPECT_EQ(line.NextTick(), 13);

  auto options = Patient();
  options.patient = false;
  ServerLine hasty(options);
  StreamAtRest(hasty);
  hasty.SocketEnded(false, "going away", 10);
  hasty.Send(Partitions(3, { BlobId::Partition(7) }), 11);
  hasty.SocketEnded(false, "refused", 11);
  const auto events = hasty.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(fixtures::Mentions(events[0].message, { "server:1 ", "refused" }));
}

TEST(TestServerLine, RetryNowMakesTheNextTickTry)
{
  ServerLine line(Patient());
  Actions(line);
  line.SocketEnded(false, "x", 0);
  line.SocketEnded(false, "x", 0);
  Actions(line);
  line.Tick(0.1);
  EXPECT_EQ(Actions(line), Names{});
  line.RetryNow();
  line.Tick(0.1);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.Tick(100); // RetryNow counts once
  EXPECT_EQ(Actions(line), Names{});
}

TEST(TestServerLine, AnImpatientLineFailsWhatIsOutstandingAndConnectsForTheNextRequest)
{
  ServerLineOptions options = Patient();
  options.patient = false;
  ServerLine line(options);
  Stream(line, 0);
  line.SocketEnded(false, "reset", 1);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  EXPECT_TRUE(line.TakeEvents().empty());
  line.SocketEnded(false, "refused", 1);
  EXPECT_EQ(Actions(line), Names{ "close" });
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[0].request, 2u);
  EXPECT_TRUE(fixtures::Mentions(events[0].message, { "server:1 ", "refused" }));
  line.Tick(1000);
  EXPECT_EQ(Actions(line), Names{});
  line.Send(Partitions(3, { BlobId::Partition(7) }), 1000);
  EXPECT_EQ(Actions(line), Names{ "connect" });
}

TEST(TestServerLine, GivesUpAConnectionThatIsStalled)
{
  ServerLineOptions options = Patient();
  options.idleTimeout = 20;
  ServerLine line(options);
  Stream(line, 0);
  line.Tick(19);
  SendPartition(line, 3, 1, 19);
  line.Tick(39);
  EXPECT_EQ(line.GetState(), State::Streaming);
  line.Tick(39.1);
  EXPECT_EQ(line.GetState(), State::Connecting);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  // What the old connection still sends is ignored.
  SendPartition(line, 3, 2, 39.2);
  line.TakeEvents();
  line.SocketOpened(40);
  EXPECT_EQ(Actions(line), (Names{ "open m", "partitions 2" }));
  SendOpened(line, 4, 40);
  SendPartition(line, 5, 2, 41);
  line.SocketText(protocol::WriteServerMessage({ 5, protocol::EndAnswer{ 1, 3, 0, false } }), 41);
  // Silence does not count while nothing is outstanding; a request after a long rest has the full
  // timeout.
  line.Tick(500);
  EXPECT_EQ(line.GetState(), State::Streaming);
  line.Send(Partitions(3, { BlobId::Partition(7) }), 500);
  line.Tick(510);
  EXPECT_EQ(line.GetState(), State::Streaming);
  line.Tick(521);
  EXPECT_EQ(line.GetState(), State::Connecting);
}

TEST(TestServerLine, GivesUpAConnectionThatDoesNotKeepToTheProtocol)
{
  ServerLine line(Patient());
  Stream(line, 0);
  line.SocketText("no JSON", 1);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  EXPECT_NE(line.Trouble().find("JSON"), std::string::npos) << line.Trouble();
  line.SocketOpened(1);
  Actions(line);
  line.SocketFrame(std::vector<std::uint8_t>(7), 1);
  EXPECT_EQ(line.GetState(), State::Lost); // the connection had brought nothing
}

TEST(TestServerLine, AConnectionThatGarblesEveryFrameIsTriedEverMoreRarely)
{
  ServerLine line(Patient());
  Stream(line, 0);
  const std::vector<std::uint8_t> garbled(7);
  // The first retry is immediate. The next one is not, if only the model was opened in between.
  line.SocketFrame(garbled, 1);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketOpened(1);
  SendOpened(line, 4, 1);
  line.SocketFrame(garbled, 1);
  EXPECT_EQ(line.GetState(), State::Lost);
  EXPECT_NE(line.Trouble(), "");
  line.Tick(2);
  EXPECT_EQ(line.GetState(), State::Connecting);
  line.SocketOpened(2);
  SendOpened(line, 6, 2);
  line.SocketFrame(garbled, 2);
  line.Tick(3.9);
  EXPECT_EQ(line.GetState(), State::Lost) << "the pauses grow";
  line.Tick(4);
  EXPECT_EQ(line.GetState(), State::Connecting);
  line.SocketOpened(4);
  SendOpened(line, 8, 4);
  SendPartition(line, 9, 1, 4);
  EXPECT_EQ(line.TakeEvents().size(), 1u);
  Actions(line);
  line.SocketFrame(garbled, 5);
  EXPECT_EQ(Actions(line), Names{ "connect" }) << "it had brought what is owed";
}

TEST(TestServerLine, WithoutAStreamEverythingIsFetched)
{
  ServerLine line(Patient());
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.Send(OpenModel(1), 0);
  line.SocketEnded(true, "404", 0);
  EXPECT_EQ(line.GetState(), State::Getting);
  EXPECT_EQ(Actions(line), Names{ "fetch /api/models/m/model.json" });
  line.Fetched(HttpReply{ 200, WriteModel(Model()) }, 0);
  ASSERT_EQ(line.TakeEvents().size(), 1u);
  line.Send(Partitions(2, { BlobId::Partition(1), BlobId::Partition(2) }), 0);
  const std::string path = "fetch /api/models/m/" + std::string(32, 'a') + "/partitions/";
  EXPECT_EQ(Actions(line), Names{ path + "1" });

  // Without a server, the same GET is repeated, with growing pauses; nothing else is fetched in
  // between.
  const auto gone = [](const char* why) { return Error{ ErrorCode::InputOutput, why }; };
  line.Fetched(gone("no route"), 10);
  EXPECT_EQ(line.Trouble(), "no route");
  line.Send(Partitions(3, { BlobId::Partition(3) }), 10);
  line.Tick(10.9);
  EXPECT_EQ(Actions(line), Names{});
  line.Tick(11);
  EXPECT_EQ(Actions(line), Names{ path + "1" });
  line.Fetched(gone("no route"), 11);
  line.Tick(12.9);
  EXPECT_EQ(Actions(line), Names{});
  line.Tick(13);
  EXPECT_EQ(Actions(line), Names{ path + "1" });
  EXPECT_TRUE(line.TakeEvents().empty());

  // A refusal counts as an answer.
  line.Fetched(HttpReply{ 404, R"({"error":"no such blob"})" }, 13);
  EXPECT_EQ(line.Trouble(), "");
  EXPECT_EQ(Actions(line), Names{ path + "2" });
  auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::BlobFailed);
  EXPECT_TRUE(fixtures::Mentions(events[0].message, { "404", "no such blob" }));

  // What was cancelled while the server was away is not fetched again.
  SessionRequest cancel;
  cancel.kind = SessionRequest::Kind::Cancel;
  cancel.id = 2;
  line.Send(cancel, 13);
  line.Fetched(gone("no route"), 13);
  line.Tick(14);
  EXPECT_EQ(Actions(line), Names{ path + "3" });
  line.Fetched(HttpReply{ 200, "abc" }, 14);
  events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::Blob);
  EXPECT_EQ(events[0].request, 3u);
}

namespace
{

// Makes the line fetch by GET, with model m open.
void Get(ServerLine& line)
{
  Actions(line);
  line.SocketEnded(true, "the server says 426", 0);
  line.Send(OpenModel(1), 0);
  EXPECT_EQ(Actions(line), Names{ "fetch /api/models/m/model.json" });
  line.Fetched(HttpReply{ 200, WriteModel(Model()) }, 0);
  EXPECT_EQ(line.TakeEvents().size(), 1u);
}
const std::string partition1 = "fetch /api/models/m/" + std::string(32, 'a') + "/partitions/1";

}

TEST(TestServerLine, ABusyServerIsAskedAgainWhenItSays)
{
  for (const unsigned status : { 429u, 502u, 503u, 504u })
  {
    ServerLine line(Patient());
    Get(line);
    line.Send(Partitions(2, { BlobId::Partition(1) }), 10);
    EXPECT_EQ(Actions(line), Names{ partition1 });
    line.Fetched(HttpReply{ status, R"({"error":"busy"})", 3 }, 10);
    EXPECT_TRUE(line.TakeEvents().empty()) << "no damage";
    EXPECT_EQ(line.Trouble(), "the server says " + std::to_string(status) + ": busy");
    EXPECT_EQ(line.NextTick(), 13);
    line.Tick(12.9);
    EXPECT_EQ(Actions(line), Names{});
    line.Tick(13);
    EXPECT_EQ(Actions(line), Names{ partition1 });
    line.Fetched(HttpReply{ 200, "abc" }, 14);
    EXPECT_EQ(line.TakeEvents().size(), 1u);
    EXPECT_EQ(line.Trouble(), "");
  }
}

TEST(TestServerLine, ABusyServerIsAskedForAStreamAgainWhenItSays)
{
  ServerLine line(Patient());
  Stream(line, 0);
  line.SocketEnded(false, "going away", 10); // the server stops; another one replaces it
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketEnded(false, "the server says 503", 10, 7);
  EXPECT_EQ(Actions(line), Names{ "close" });
  EXPECT_EQ(line.NextTick(), 17);
  line.Tick(17);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketEnded(false, "the server says 503", 17, 0.5); // less than the line's own pause
  EXPECT_EQ(line.NextTick(), 19);

  ServerLine first(Patient());
  EXPECT_EQ(Actions(first), Names{ "connect" });
  first.SocketEnded(false, "the server says 503", 0, 7);
  EXPECT_EQ(Actions(first), Names{ "close" }) << "not at once: it has said so";
  EXPECT_EQ(first.NextTick(), 7);
}

TEST(TestServerLine, AnImpatientLineWaitsForABusyServersStreamAFewTimes)
{
  ServerLineOptions options = Patient();
  options.patient = false;
  options.mostTries = 3;
  ServerLine line(options);
  line.Send(OpenModel(1), 0);
  double now = 0;
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(Actions(line), Names{ "connect" });
    line.SocketEnded(false, "the server says 503", now, 2);
    EXPECT_EQ(Actions(line), Names{ "close" });
    EXPECT_TRUE(line.TakeEvents().empty());
    EXPECT_GE(line.NextTick(), now + 2);
    now = line.NextTick();
    line.Tick(now);
  }
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketEnded(false, "the server says 503", now, 2);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
}

TEST(TestServerLine, AnImpatientLineAsksABusyServerAFewTimes)
{
  ServerLineOptions options;
  options.mostTries = 3;
  ServerLine line(options);
  Get(line);
  line.Send(Partitions(2, { BlobId::Partition(1) }), 0);
  double now = 0;
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(Actions(line), Names{ partition1 });
    line.Fetched(HttpReply{ 503, "" }, now);
    EXPECT_TRUE(line.TakeEvents().empty());
    now = line.NextTick();
    line.Tick(now);
  }
  line.Fetched(HttpReply{ 503, "" }, now);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::BlobFailed);
}

TEST(TestServerLine, WhoMayNotHaveAModelHasNoDamage)
{
  ServerLine line({});
  Get(line);
  line.Send(Partitions(2, { BlobId::Partition(1), BlobId::Partition(2) }), 0);
  Actions(line);
  line.Fetched(HttpReply{ 403, "" }, 0);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(Actions(line), Names{}) << "the others are not asked for";
  EXPECT_EQ(line.GetState(), State::Getting);
}

// A client that may not have something still gets everything else. A token may come later, so then
// it asks again.
TEST(TestServerLine, APatientLineAsksAgainOnlyForWhatItMayHaveLater)
{
  ServerLine line(Patient());
  Get(line);
  line.Send(Partitions(2, { BlobId::Partition(7) }), 10);
  Actions(line);
  line.Send(Partitions(3, { BlobId::Partition(1) }), 10);
  line.Fetched(HttpReply{ 403, R"({"error":"the quota is used up"})", 3000 }, 10);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_TRUE(fixtures::Mentions(events[0].message, { "403", "the quota is used up" }));
  EXPECT_EQ(Actions(line), Names{ partition1 });
  line.Fetched(HttpReply{ 401, "" }, 11);
  EXPECT_TRUE(line.TakeEvents().empty());
  EXPECT_EQ(line.NextTick(), 12);
  line.Tick(12);
  EXPECT_EQ(Actions(line), Names{ partition1 });
}

TEST(TestServerLine, WhatABusyStreamDoesNotSendIsAskedForAgain)
{
  ServerLine line(Patient());
  Stream(line, 0);
  SendPartition(line, 3, 1, 1);
  line.TakeEvents();
  const auto say = [&line](
                     decltype(protocol::ServerMessage::body) body, std::uint32_t wire, double now) {
    line.SocketText(protocol::WriteServerMessage({ wire, std::move(body) }), now);
  };
  say(protocol::ErrorAnswer{ 503, "cannot be read", BlobId::Partition(2) }, 3, 2);
  say(protocol::EndAnswer{ 1, 3, 1, false }, 3, 2);
  EXPECT_TRUE(line.TakeEvents().empty());
  EXPECT_EQ(line.NextTick(), 3);
  line.Tick(3);
  EXPECT_EQ(Actions(line), Names{ "partitions 2" });
  say(protocol::ErrorAnswer{ 429, "too many requests", std::nullopt }, 4, 4);
  EXPECT_TRUE(line.TakeEvents().empty());
  line.Tick(line.NextTick());
  EXPECT_EQ(Actions(line), Names{ "partitions 2" });
  SendPartition(line, 5, 2, 6);
  EXPECT_EQ(line.TakeEvents().size(), 1u);
  say(protocol::ErrorAnswer{ 500, "damaged", BlobId::Partition(7) }, 5, 6);
  say(protocol::EndAnswer{ 1, 3, 0, false }, 5, 6);
  line.Tick(100);
  EXPECT_EQ(Actions(line), Names{}) << "nothing is owed";
}

TEST(TestServerLine, AnImpatientStreamGivesUpABusyServer)
{
  ServerLineOptions options;
  options.mostTries = 2;
  ServerLine line(options);
  Stream(line, 0);
  for (std::uint32_t wire = 3; wire < 6; ++wire)
  {
    EXPECT_TRUE(line.TakeEvents().empty());
    line.SocketText(protocol::WriteServerMessage(
                      { wire, protocol::ErrorAnswer{ 429, "too many requests", std::nullopt } }),
      wire);
    line.Tick(line.NextTick());
  }
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[0].message, "too many requests");
}

TEST(TestServerLine, AServerWithoutAStreamIsAskedForOneLater)
{
  auto options = Patient();
  options.streamRetry = 60;
  ServerLine line(options);
  Get(line);
  EXPECT_EQ(line.NextTick(), 60);
  line.Send(Partitions(2, { BlobId::Partition(1) }), 59);
  EXPECT_EQ(Actions(line), Names{ partition1 });
  line.Tick(60);
  EXPECT_EQ(Actions(line), Names{}) << "not while something is under way";
  line.Fetched(HttpReply{ 200, "abc" }, 60);
  line.TakeEvents();
  line.Tick(61);
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.Send(Partitions(3, { BlobId::Partition(1) }), 61);
  EXPECT_EQ(Actions(line), Names{});
  line.SocketEnded(false, "reset", 62); // still no stream, or no answer
  EXPECT_EQ(line.GetState(), State::Getting);
  EXPECT_EQ(Actions(line), Names{ partition1 });
  line.Fetched(HttpReply{ 200, "abc" }, 62);
  EXPECT_EQ(line.TakeEvents().size(), 1u);

  line.Tick(line.NextTick());
  EXPECT_EQ(Actions(line), Names{ "connect" });
  line.SocketOpened(130);
  EXPECT_EQ(Actions(line), Names{ "open m" });
  SendOpened(line, 1, 130);
  EXPECT_TRUE(line.TakeEvents().empty());
  line.Send(Partitions(4, { BlobId::Partition(2) }), 130);
  EXPECT_EQ(Actions(line), Names{ "partitions 2" });
  EXPECT_EQ(line.NextTick(), std::numeric_limits<double>::infinity());
}

TEST(TestServerLine, ClientsComeBackAtDifferentTimes)
{
  auto options = Patient();
  options.jitter = 2;
  std::vector<double> pauses, idle;
  for (int i = 0; i < 1000; ++i)
  {
    ServerLine line(options);
    const double now = 100 + i * 1e-6;
    line.SocketEnded(false, "reset", now); // connects again at once
    line.SocketEnded(false, "reset", now);
    pauses.push_back(line.NextTick() - now);
    EXPECT_GE(pauses.back(), 1);
    EXPECT_LE(pauses.back(), 3);
    ServerLine resting(options);
    resting.SocketOpened(now);
    resting.SocketEnded(false, "going away", now);
    idle.push_back(resting.NextTick() - now);
  }
  std::sort(pauses.begin(), pauses.end());
  std::sort(idle.begin(), idle.end());
  for (const double share : { 0.25, 0.5, 0.75 })
  {
    EXPECT_NEAR(pauses[static_cast<std::size_t>(1000 * share)], 1 + 2 * share, 0.15);
    EXPECT_NEAR(idle[static_cast<std::size_t>(1000 * share)], 2 + 4 * share, 0.3);
  }
}

TEST(TestServerLine, WithoutPatienceALostServerIsTheAnswerOfAFetch)
{
  ServerLineOptions options = Patient();
  options.patient = false;
  ServerLine line(options);
  line.Send(OpenModel(1), 0);
  line.SocketEnded(true, "404", 0);
  Actions(line);
  line.Fetched(Error{ ErrorCode::InputOutput, "no route" }, 0);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[0].message, "no route");
}

}
