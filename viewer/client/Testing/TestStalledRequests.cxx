// SPDX-License-Identifier: BSD-3-Clause
// A server that never sends an outstanding blob, but always something else, is given up, and the
// message names the piece. A slow server, or one that sends in another order, is not given up.
#include "Testing/Fixtures/ErrorAt.h"
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

constexpr double stallTimeout = 60; // s

ServerLineOptions Page()
{
  ServerLineOptions options;
  options.authority = "server:1";
  options.patient = true;
  options.idleTimeout = 20;
  options.stallTimeout = stallTimeout;
  return options;
}

// A ServerLine, the server at its other end, and a clock.
class StreamTest
{
public:
  struct Asked
  {
    std::uint32_t wire = 0;
    std::vector<std::uint32_t> partitions;
  };

  explicit StreamTest(const ServerLineOptions& options = Page())
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
  // Lets `seconds` pass; the host calls Tick now and then.
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
  void Cancel(std::uint32_t request)
  {
    SessionRequest cancel;
    cancel.kind = SessionRequest::Kind::Cancel;
    cancel.id = request;
    this->Line.Send(cancel, this->Now);
    this->Listen();
  }
  // The server sends one frame of a blob of `total` bytes.
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
  std::vector<Asked> Asking; // requests over this connection, in order
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

// What a server may send forever instead of partition 1.
using Chatter = std::function<void(StreamTest& stream, std::uint32_t step)>;
const std::map<std::string, Chatter> chatters{
  { "answers to what was asked for later",
    [](StreamTest& stream, std::uint32_t step)
    {
      stream.Ask(100 + step, { 100 + step });
      stream.SayFrame(stream.Asking.back().wire, 100 + step);
      stream.SayEnd(stream.Asking.back().wire);
    } },
  { "pieces that nobody asked for", [](StreamTest& stream, std::uint32_t step)
    { stream.SayFrame(stream.Asking.front().wire, 1000 + step); } },
  { "one piece over and over",
    [](StreamTest& stream, std::uint32_t) { stream.SayFrame(stream.Asking.front().wire, 2); } },
  { "a piece that was called back, over and over",
    [](StreamTest& stream, std::uint32_t step)
    {
      if (step == 1)
      {
        stream.Ask(50, { 50, 51 });
        stream.Cancel(50);
      }
      stream.SayFrame(stream.Asking.back().wire, 50);
    } },
  { "answers to nothing",
    [](StreamTest& stream, std::uint32_t step) { stream.SayFrame(9999, step); } },
  { "that it begins",
    [](StreamTest& stream, std::uint32_t)
    {
      stream.Line.SocketText(protocol::WriteServerMessage(
                               { stream.Asking.front().wire, protocol::BeginAnswer{ 1, 3, {} } }),
        stream.Now);
    } },
};

TEST(TestStalledRequests, AServerThatAlwaysSendsOthersIsGivenUpAndThePieceIsNamed)
{
  for (const auto& [what, chatter] : chatters)
  {
    StreamTest stream;
    stream.Ask(2, { 1, 2, 3 });
    std::uint32_t step = 0;
    while (stream.Line.GetState() == State::Streaming && stream.Now < 1000)
    {
      chatter(stream, ++step);
      stream.Pass(1);
    }
    stream.Take();
    EXPECT_LT(stream.Now, 3 * stallTimeout) << what;
    ASSERT_EQ(stream.Count(EventKind::BlobFailed), 1u) << what;
    const ClientEvent failed = *std::find_if(stream.Events.begin(), stream.Events.end(),
      [](const ClientEvent& event) { return event.kind == EventKind::BlobFailed; });
    EXPECT_EQ(failed.request, 2u) << what;
    EXPECT_EQ(failed.blob, BlobId::Partition(1)) << what;
    EXPECT_TRUE(fixtures::Mentions(stream.Line.Trouble(), { "server:1 ", "not answered" }));

    // The other blobs are requested again.
    stream.Open();
    stream.SayOpened();
    ASSERT_FALSE(stream.Asking.empty()) << what;
    const std::vector<std::uint32_t> left = stream.Asking.front().partitions;
    EXPECT_EQ(std::count(left.begin(), left.end(), 1u), 0) << what;
    EXPECT_EQ(std::count(left.begin(), left.end(), 3u), 1) << what;

    // The session may request the failed piece again.
    stream.Ask(3, { 1 });
    EXPECT_EQ(stream.Asking.back().partitions, std::vector<std::uint32_t>{ 1 });
    stream.SayFrame(stream.Asking.front().wire, 3);
    stream.SayFrame(stream.Asking.back().wire, 1);
    EXPECT_EQ(stream.Events.back().blob, BlobId::Partition(1));
    EXPECT_EQ(stream.Events.back().kind, EventKind::Blob);
  }
}

TEST(TestStalledRequests, AModelThatIsNeverOpenedIsNamedToo)
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
  EXPECT_LT(now, 3 * stallTimeout);
  const auto events = line.TakeEvents();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[0].request, 1u);
}

// NextTick gives a host's timer the time of the next timeout, and no time for what does not count.
TEST(TestStalledRequests, TheNextTickIsWhenPatienceEnds)
{
  constexpr double never = std::numeric_limits<double>::infinity();
  StreamTest stream;
  EXPECT_EQ(stream.Line.NextTick(), never);
  stream.Ask(2, { 1 });
  EXPECT_EQ(stream.Line.NextTick(), never) << "silence is not for it to judge";
  stream.Now = 5;
  stream.Ask(3, { 2 });
  stream.SayFrame(stream.Asking.back().wire, 2);
  EXPECT_EQ(stream.Line.NextTick(), never) << "a server that answers in another order";
  stream.Now = 7;
  stream.Ask(4, { 4 });
  stream.Ask(5, { 5 });
  for (std::size_t i = 0; i <= StreamConversation::mostStrays; ++i)
  {
    stream.SayFrame(9999, 7);
  }
  EXPECT_EQ(stream.Line.NextTick(), 7 + stallTimeout);
  stream.SayFrame(stream.Asking.front().wire, 1);
  EXPECT_EQ(stream.Line.NextTick(), never);
}

// A blob in transit: where its next frame begins.
struct Blob
{
  std::uint32_t wire = 0, partition = 0, total = 0, sent = 0;
};
constexpr std::uint32_t largeBlob = 600'000;
constexpr double slowLine = 5'000; // bytes a second

// Sends the next frame of a blob, as slowly as the connection is.
void SendFrame(StreamTest& stream, Blob& blob)
{
  const std::uint32_t bytes = std::min<std::uint32_t>(
    blob.total - blob.sent, static_cast<std::uint32_t>(protocol::maximumPayloadBytes));
  stream.Pass(bytes / slowLine);
  stream.SayFrame(blob.wire, blob.partition, blob.sent, blob.total);
  blob.sent += bytes;
}

void SendAll(StreamTest& stream, Blob& blob)
{
  while (blob.sent < blob.total)
  {
    SendFrame(stream, blob);
  }
}

std::vector<Blob> BlobsOf(const StreamTest& stream)
{
  std::vector<Blob> blobs;
  for (const StreamTest::Asked& asked : stream.Asking)
  {
    for (const std::uint32_t partition : asked.partitions)
    {
      blobs.push_back({ asked.wire, partition, largeBlob });
    }
  }
  return blobs;
}

void ExpectAllArrived(StreamTest& stream, std::size_t blobs)
{
  EXPECT_EQ(stream.Line.GetState(), State::Streaming);
  EXPECT_EQ(stream.Line.Trouble(), "");
  EXPECT_EQ(stream.Count(EventKind::Blob), blobs);
  EXPECT_EQ(stream.Count(EventKind::BlobFailed), 0u);
  EXPECT_EQ(stream.Count(EventKind::RequestFailed), 0u);
}

TEST(TestStalledRequests, ASlowLineIsNotGivenUp)
{
  StreamTest stream;
  stream.Ask(2, { 1, 2 });
  stream.Ask(3, { 3 });
  std::vector<Blob> blobs = BlobsOf(stream);
  for (Blob& blob : blobs)
  {
    SendAll(stream, blob);
  }
  EXPECT_GT(stream.Now, 5 * stallTimeout);
  ExpectAllArrived(stream, 3);
}

TEST(TestStalledRequests, OneThatSendsTheLastFirstIsNotGivenUp)
{
  StreamTest stream;
  for (std::uint32_t request = 2; request < 8; ++request)
  {
    stream.Ask(request, { request });
  }
  std::vector<Blob> blobs = BlobsOf(stream);
  for (auto blob = blobs.rbegin(); blob != blobs.rend(); ++blob)
  {
    SendAll(stream, *blob);
  }
  EXPECT_GT(stream.Now, 10 * stallTimeout);
  ExpectAllArrived(stream, 6);
}

TEST(TestStalledRequests, OneThatSendsInTurnsIsNotGivenUp)
{
  StreamTest stream;
  for (std::uint32_t request = 2; request < 10; ++request)
  {
    stream.Ask(request, { request });
  }
  std::vector<Blob> blobs = BlobsOf(stream);
  while (blobs.front().sent < largeBlob)
  {
    for (Blob& blob : blobs)
    {
      SendFrame(stream, blob);
    }
  }
  ExpectAllArrived(stream, 8);
}

// A cancelled blob may still be in flight.
TEST(TestStalledRequests, WhatWasCancelledMayComeBefore)
{
  StreamTest stream;
  stream.Ask(2, { 1 });
  stream.Cancel(2);
  stream.Ask(3, { 2 });
  std::vector<Blob> blobs = BlobsOf(stream);
  ASSERT_EQ(blobs.size(), 2u);
  for (Blob& blob : blobs)
  {
    SendAll(stream, blob);
  }
  EXPECT_GT(stream.Now, 3 * stallTimeout);
  ExpectAllArrived(stream, 1);
}

// The connection was fast, with much in flight, and has become slow.
TEST(TestStalledRequests, MuchThatWasCancelledMayComeBefore)
{
  StreamTest stream;
  std::vector<std::uint32_t> many(4 * StreamConversation::mostStrays);
  std::iota(many.begin(), many.end(), 100u);
  stream.Ask(2, many);
  stream.Cancel(2);
  stream.Ask(3, { 2 });
  std::vector<Blob> blobs = BlobsOf(stream);
  ASSERT_EQ(blobs.size(), many.size() + 1);
  for (Blob& blob : blobs)
  {
    blob.total = protocol::maximumPayloadBytes;
    SendFrame(stream, blob);
  }
  EXPECT_GT(stream.Now, 10 * stallTimeout);
  ExpectAllArrived(stream, 1);
}

}
