// SPDX-License-Identifier: BSD-3-Clause
// A server that never sends what is waited for, but always something else, is given up, and the
// message names the piece; one that is slow, or sends in another order, is not.
#include "viewer/client/ServerLine.h"
#include "viewer/client/Testing/SessionRequests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using ActionKind = ServerLine::Action::Kind;
using State = ServerLine::State;
using EventKind = ClientEvent::Kind;
using protocol::BlobId;

namespace
{

constexpr double longestDebt = 60; // s

ServerLineOptions Page()
{
  ServerLineOptions options;
  options.authority = "server:1";
  options.patient = true;
  options.longestSilence = 20;
  options.longestDebt = longestDebt;
  return options;
}

// A line, the server at its other end, and the time.
class Talk
{
public:
  struct Asked
  {
    std::uint32_t wire = 0;
    std::vector<std::uint32_t> partitions;
  };

  explicit Talk(const ServerLineOptions& options = Page())
    : Line(options)
  {
    this->Open();
    SessionRequest open;
    open.id = 1;
    open.model = "m";
    this->Line.Send(open, this->Now);
    this->Listen();
    this->SayOpened();
  }

  void Open()
  {
    this->Asking.clear();
    this->Line.SocketOpened(this->Now);
    this->Listen();
  }
  void SayOpened()
  {
    ModelDescription model;
    model.id = "m";
    model.digest = std::string(32, 'a');
    model.vertices = 1;
    model.box = { { 0, 0, 0 }, { 1, 1, 1 } };
    model.levels.resize(1);
    this->Line.SocketText(
      protocol::WriteServerMessage({ this->OpenWire, protocol::OpenedAnswer{ model } }), this->Now);
    this->Listen();
  }
  // `seconds` pass, in which the host looks now and then.
  void Pass(double seconds)
  {
    for (double end = this->Now + seconds; this->Now < end;)
    {
      this->Now = std::min(this->Now + 1, end);
      this->Line.Tick(this->Now);
    }
  }
  void Ask(std::uint32_t request, const std::vector<std::uint32_t>& partitions)
  {
    std::vector<BlobId> blobs;
    std::transform(partitions.begin(), partitions.end(), std::back_inserter(blobs),
      [](std::uint32_t each) { return BlobId::Partition(each); });
    this->Line.Send(Partitions(request, blobs), this->Now);
    this->Listen();
  }
  void CallBack(std::uint32_t request)
  {
    SessionRequest cancel;
    cancel.kind = SessionRequest::Kind::Cancel;
    cancel.id = request;
    this->Line.Send(cancel, this->Now);
    this->Listen();
  }
  // One frame of a blob of so many bytes.
  void SayFrame(
    std::uint32_t wire, std::uint32_t partition, std::uint32_t offset = 0, std::uint32_t total = 3)
  {
    const std::vector<std::uint8_t> payload(
      std::min<std::size_t>(total - offset, protocol::maximumPayloadBytes), 1);
    this->Line.SocketFrame(
      protocol::EncodeFrame({ wire, BlobId::Partition(partition), offset, total }, payload),
      this->Now);
    this->Take();
  }
  void SayEnd(std::uint32_t wire)
  {
    this->Line.SocketText(
      protocol::WriteServerMessage({ wire, protocol::EndAnswer{ 1, 3, 0, false } }), this->Now);
    this->Take();
    this->Listen();
  }
  void Take()
  {
    for (ClientEvent& event : this->Line.TakeEvents())
    {
      this->Events.push_back(std::move(event));
    }
  }
  std::size_t Count(EventKind kind) const
  {
    return static_cast<std::size_t>(std::count_if(this->Events.begin(), this->Events.end(),
      [kind](const ClientEvent& event) { return event.kind == kind; }));
  }

  ServerLine Line;
  double Now = 0;
  std::vector<Asked> Asking; // over this connection, in order
  std::vector<ClientEvent> Events;

private:
  void Listen()
  {
    for (const ServerLine::Action& action : this->Line.TakeActions())
    {
      if (action.kind != ActionKind::Send)
      {
        continue;
      }
      const auto message = protocol::ParseClientMessage(action.text);
      ASSERT_TRUE(message);
      if (const auto* list = std::get_if<protocol::BlobsRequest>(&message->body))
      {
        this->Asking.push_back({ message->request, {} });
        for (const BlobId& partition : list->blobs)
        {
          this->Asking.back().partitions.push_back(partition.number);
        }
      }
      else if (std::holds_alternative<protocol::OpenRequest>(message->body))
      {
        this->OpenWire = message->request;
      }
    }
  }

  std::uint32_t OpenWire = 0;
};

// What a server may say for ever instead of partition 1.
using Chatter = std::function<void(Talk& talk, std::uint32_t step)>;
const std::map<std::string, Chatter> chatters{
  { "answers to what was asked for later",
    [](Talk& talk, std::uint32_t step)
    {
      talk.Ask(100 + step, { 100 + step });
      talk.SayFrame(talk.Asking.back().wire, 100 + step);
      talk.SayEnd(talk.Asking.back().wire);
    } },
  { "pieces that nobody asked for",
    [](Talk& talk, std::uint32_t step) { talk.SayFrame(talk.Asking.front().wire, 1000 + step); } },
  { "one piece over and over",
    [](Talk& talk, std::uint32_t) { talk.SayFrame(talk.Asking.front().wire, 2); } },
  { "a piece that was called back, over and over",
    [](Talk& talk, std::uint32_t step)
    {
      if (step == 1)
      {
        talk.Ask(50, { 50, 51 });
        talk.CallBack(50);
      }
      talk.SayFrame(talk.Asking.back().wire, 50);
    } },
  { "answers to nothing", [](Talk& talk, std::uint32_t step) { talk.SayFrame(9999, step); } },
  { "that it begins",
    [](Talk& talk, std::uint32_t)
    {
      talk.Line.SocketText(protocol::WriteServerMessage(
                             { talk.Asking.front().wire, protocol::BeginAnswer{ 1, 3, {} } }),
        talk.Now);
    } },
};

TEST(TestLongestOwed, AServerThatAlwaysSendsOthersIsGivenUpAndThePieceIsNamed)
{
  for (const auto& [what, chatter] : chatters)
  {
    Talk talk;
    talk.Ask(2, { 1, 2, 3 });
    std::uint32_t step = 0;
    while (talk.Line.GetState() == State::Streaming && talk.Now < 1000)
    {
      chatter(talk, ++step);
      talk.Pass(1);
    }
    talk.Take();
    EXPECT_LT(talk.Now, 3 * longestDebt) << what;
    ASSERT_EQ(talk.Count(EventKind::BlobFailed), 1u) << what;
    const ClientEvent failed = *std::find_if(talk.Events.begin(), talk.Events.end(),
      [](const ClientEvent& event) { return event.kind == EventKind::BlobFailed; });
    EXPECT_EQ(failed.request, 2u) << what;
    EXPECT_EQ(failed.blob, BlobId::Partition(1)) << what;
    EXPECT_EQ(failed.message, "the server sends other data instead");
    EXPECT_EQ(talk.Line.Trouble(),
      "the connection to server:1 was lost: the oldest request was not answered");

    // The others are asked for again.
    talk.Open();
    talk.SayOpened();
    ASSERT_FALSE(talk.Asking.empty()) << what;
    const std::vector<std::uint32_t> left = talk.Asking.front().partitions;
    EXPECT_EQ(std::count(left.begin(), left.end(), 1u), 0) << what;
    EXPECT_EQ(std::count(left.begin(), left.end(), 3u), 1) << what;

    // And so is the piece, when it is asked for anew.
    talk.Ask(3, { 1 });
    EXPECT_EQ(talk.Asking.back().partitions, std::vector<std::uint32_t>{ 1 });
    talk.SayFrame(talk.Asking.front().wire, 3);
    talk.SayFrame(talk.Asking.back().wire, 1);
    EXPECT_EQ(talk.Events.back().blob, BlobId::Partition(1));
    EXPECT_EQ(talk.Events.back().kind, EventKind::Blob);
  }
}

TEST(TestLongestOwed, AModelThatIsNeverOpenedIsNamedToo)
{
  ServerLine line(Page());
  line.SocketOpened(0);
  SessionRequest open;
  open.id = 1;
  open.model = "m";
  line.Send(open, 0);
  double now = 0;
  for (; line.GetState() == State::Streaming && now < 1000; now += 1)
  {
    line.SocketText(
      protocol::WriteServerMessage({ 77, protocol::EndAnswer{ 1, 3, 0, false } }), now);
    line.Tick(now);
  }
  EXPECT_LT(now, 3 * longestDebt);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[0].request, 1u);
}

// A host whose timer asks NextTick is told in time, and never of what does not count.
TEST(TestLongestOwed, TheNextTickIsWhenPatienceEnds)
{
  constexpr double never = std::numeric_limits<double>::infinity();
  Talk talk;
  EXPECT_EQ(talk.Line.NextTick(), never);
  talk.Ask(2, { 1 });
  EXPECT_EQ(talk.Line.NextTick(), never) << "silence is not for it to judge";
  talk.Now = 5;
  talk.Ask(3, { 2 });
  talk.SayFrame(talk.Asking.back().wire, 2);
  EXPECT_EQ(talk.Line.NextTick(), never) << "a server that answers in another order";
  talk.Now = 7;
  talk.Ask(4, { 4 });
  talk.Ask(5, { 5 });
  for (std::size_t i = 0; i <= StreamConversation::mostStrays; ++i)
  {
    talk.SayFrame(9999, 7);
  }
  EXPECT_EQ(talk.Line.NextTick(), 7 + longestDebt);
  talk.SayFrame(talk.Asking.front().wire, 1);
  EXPECT_EQ(talk.Line.NextTick(), never);
}

// Of a blob: where its next frame begins.
struct Blob
{
  std::uint32_t wire = 0, partition = 0, total = 0, sent = 0;
};
constexpr std::uint32_t largeBlob = 600'000;
constexpr double slowLine = 5'000; // bytes a second

// The next frame of a blob comes as slowly as the line is.
void SendFrame(Talk& talk, Blob& blob)
{
  const std::uint32_t bytes = std::min<std::uint32_t>(
    blob.total - blob.sent, static_cast<std::uint32_t>(protocol::maximumPayloadBytes));
  talk.Pass(bytes / slowLine);
  talk.SayFrame(blob.wire, blob.partition, blob.sent, blob.total);
  blob.sent += bytes;
}

void SendAll(Talk& talk, Blob& blob)
{
  while (blob.sent < blob.total)
  {
    SendFrame(talk, blob);
  }
}

std::vector<Blob> BlobsOf(const Talk& talk)
{
  std::vector<Blob> blobs;
  for (const Talk::Asked& asked : talk.Asking)
  {
    for (const std::uint32_t partition : asked.partitions)
    {
      blobs.push_back({ asked.wire, partition, largeBlob });
    }
  }
  return blobs;
}

void ExpectAllCame(Talk& talk, std::size_t blobs)
{
  EXPECT_EQ(talk.Line.GetState(), State::Streaming);
  EXPECT_EQ(talk.Line.Trouble(), "");
  EXPECT_EQ(talk.Count(EventKind::Blob), blobs);
  EXPECT_EQ(talk.Count(EventKind::BlobFailed), 0u);
  EXPECT_EQ(talk.Count(EventKind::RequestFailed), 0u);
}

TEST(TestLongestOwed, ASlowLineIsNotGivenUp)
{
  Talk talk;
  talk.Ask(2, { 1, 2 });
  talk.Ask(3, { 3 });
  std::vector<Blob> blobs = BlobsOf(talk);
  for (Blob& blob : blobs)
  {
    SendAll(talk, blob);
  }
  EXPECT_GT(talk.Now, 5 * longestDebt);
  ExpectAllCame(talk, 3);
}

TEST(TestLongestOwed, OneThatSendsTheLastFirstIsNotGivenUp)
{
  Talk talk;
  for (std::uint32_t request = 2; request < 8; ++request)
  {
    talk.Ask(request, { request });
  }
  std::vector<Blob> blobs = BlobsOf(talk);
  for (auto blob = blobs.rbegin(); blob != blobs.rend(); ++blob)
  {
    SendAll(talk, *blob);
  }
  EXPECT_GT(talk.Now, 10 * longestDebt);
  ExpectAllCame(talk, 6);
}

TEST(TestLongestOwed, OneThatSendsInTurnsIsNotGivenUp)
{
  Talk talk;
  for (std::uint32_t request = 2; request < 10; ++request)
  {
    talk.Ask(request, { request });
  }
  std::vector<Blob> blobs = BlobsOf(talk);
  while (blobs.front().sent < largeBlob)
  {
    for (Blob& blob : blobs)
    {
      SendFrame(talk, blob);
    }
  }
  ExpectAllCame(talk, 8);
}

// What was called back may be on its way still.
TEST(TestLongestOwed, WhatWasCalledBackMayComeBefore)
{
  Talk talk;
  talk.Ask(2, { 1 });
  talk.CallBack(2);
  talk.Ask(3, { 2 });
  std::vector<Blob> blobs = BlobsOf(talk);
  ASSERT_EQ(blobs.size(), 2u);
  for (Blob& blob : blobs)
  {
    SendAll(talk, blob);
  }
  EXPECT_GT(talk.Now, 3 * longestDebt);
  ExpectAllCame(talk, 1);
}

// Of a line that was quick, and carried much at a time, until it became slow.
TEST(TestLongestOwed, MuchThatWasCalledBackMayComeBefore)
{
  Talk talk;
  std::vector<std::uint32_t> many(4 * StreamConversation::mostStrays);
  std::iota(many.begin(), many.end(), 100u);
  talk.Ask(2, many);
  talk.CallBack(2);
  talk.Ask(3, { 2 });
  std::vector<Blob> blobs = BlobsOf(talk);
  ASSERT_EQ(blobs.size(), many.size() + 1);
  for (Blob& blob : blobs)
  {
    blob.total = protocol::maximumPayloadBytes;
    SendFrame(talk, blob);
  }
  EXPECT_GT(talk.Now, 10 * longestDebt);
  ExpectAllCame(talk, 1);
}

}
