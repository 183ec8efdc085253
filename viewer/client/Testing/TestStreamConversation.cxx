// SPDX-License-Identifier: BSD-3-Clause
// Requests as messages and answers as events, without sockets: lists, limits, cancels, lost
// connections.
#include "viewer/client/StreamConversation.h"
#include "viewer/client/Testing/SessionRequests.h"

#include <gtest/gtest.h>

#include <random>

using namespace kdstream;
using kdstream::testing::OpenModel;
using Kind = SessionRequest::Kind;
using EventKind = ClientEvent::Kind;
using protocol::BlobId;

namespace
{

SessionRequest Partitions(std::uint32_t id, std::uint32_t count, std::uint32_t first = 0)
{
  SessionRequest request;
  request.kind = Kind::Blobs;
  request.id = id;
  for (std::uint32_t i = 0; i < count; ++i)
  {
    request.blobs.push_back(BlobId::Partition(first + i));
  }
  return request;
}

ModelDescription Model(char digest)
{
  ModelDescription model;
  model.id = "m";
  model.digest = std::string(32, digest);
  model.vertices = 1;
  model.box = { { 0, 0, 0 }, { 1, 1, 1 } };
  model.levels.resize(1);
  return model;
}

std::vector<protocol::ClientMessage> Parse(const std::vector<std::string>& texts)
{
  std::vector<protocol::ClientMessage> messages;
  for (const std::string& text : texts)
  {
    const auto message = protocol::ParseClientMessage(text); // refuses messages that are too long
    EXPECT_TRUE(message) << text;
    messages.push_back(*message);
  }
  return messages;
}

void Receive(StreamConversation& conversation, std::uint32_t wire,
  decltype(protocol::ServerMessage::body) body)
{
  ASSERT_TRUE(conversation.ReceiveText(protocol::WriteServerMessage({ wire, std::move(body) }), 0));
}

void ReceiveBlob(
  StreamConversation& conversation, std::uint32_t wire, const BlobId& blob, double now = 0)
{
  const std::vector<std::uint8_t> payload{ 1, 2, 3 };
  ASSERT_TRUE(conversation.ReceiveFrame(protocol::EncodeFrame({ wire, blob, 0, 3 }, payload), now));
}

TEST(TestStreamConversation, LongListsAreCutAndTheNumberOfMessagesInFlightIsLimited)
{
  StreamConversation conversation;
  SessionRequest request = Partitions(5, 10000, 1'000'000'000u);
  conversation.Send(request, 0);
  std::vector<BlobId> asked;
  std::size_t unfinished = 0;
  for (;;)
  {
    const auto messages = Parse(conversation.TakeMessages());
    if (messages.empty())
    {
      break;
    }
    unfinished += messages.size();
    EXPECT_LE(unfinished, StreamConversation::mostUnfinished);
    for (const auto& message : messages)
    {
      const auto& list = std::get<protocol::BlobsRequest>(message.body).blobs;
      asked.insert(asked.end(), list.begin(), list.end());
      for (const BlobId& partition : list)
      {
        ReceiveBlob(conversation, message.request, partition);
      }
    }
    Receive(conversation, messages.front().request, protocol::EndAnswer{});
    for (std::size_t i = 1; i < messages.size(); ++i)
    {
      Receive(conversation, messages[i].request, protocol::EndAnswer{});
    }
    unfinished = 0;
  }
  EXPECT_EQ(asked, request.blobs);
  const auto events = conversation.TakeEvents();
  EXPECT_EQ(events.size(), 10000u); // all blobs, and no event about an end
  EXPECT_FALSE(conversation.IsWaiting());
}

// Blobs of all kinds are requested by one kind of message.
TEST(TestStreamConversation, BlobsOfAnyKindAreAskedForByTheirNames)
{
  StreamConversation conversation;
  const std::vector<std::vector<BlobId>> lists{ { BlobId::LevelPiece(11, 1) },
    { BlobId::TreePage(1), BlobId::TreePage(32) }, { BlobId::PartitionBoxes(4) },
    { BlobId::Partition(7), BlobId::Partition(9) },
    { BlobId::Partition(7), BlobId::LevelPiece(12, 3), BlobId::Texture(7) } };
  for (std::uint32_t i = 0; i < lists.size(); ++i)
  {
    SessionRequest request = Partitions(i + 1, 0);
    request.blobs = lists[i];
    conversation.Send(request, 0);
  }
  const auto messages = Parse(conversation.TakeMessages());
  ASSERT_EQ(messages.size(), lists.size());
  for (std::size_t i = 0; i < lists.size(); ++i)
  {
    EXPECT_EQ(std::get<protocol::BlobsRequest>(messages[i].body).blobs, lists[i]);
  }
}

TEST(TestStreamConversation, TimesRunFromTheRequestOrTheBlobBefore)
{
  StreamConversation conversation;
  conversation.Send(Partitions(1, 2), 10);
  ReceiveBlob(conversation, 1, BlobId::Partition(0), 11.5);
  ReceiveBlob(conversation, 1, BlobId::Partition(1), 12);
  const auto events = conversation.TakeEvents();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].transmissionSeconds, 1.5);
  EXPECT_EQ(events[1].transmissionSeconds, 0.5);
  EXPECT_EQ(events[1].bytes, (std::vector<std::uint8_t>{ 1, 2, 3 }));
}

TEST(TestStreamConversation, ErrorsReachTheirRequests)
{
  StreamConversation conversation;
  conversation.Send(Partitions(1, 2), 0);
  conversation.Send(Partitions(2, 1, 9), 0);
  conversation.Send(Partitions(3, 1, 20), 0);
  conversation.TakeMessages();
  Receive(conversation, 1, protocol::ErrorAnswer{ 500, "damaged", BlobId::Partition(0) });
  Receive(conversation, 1, protocol::ErrorAnswer{ 500, "again", BlobId::Partition(0) });
  Receive(conversation, 1, protocol::ErrorAnswer{ 500, "not asked", BlobId::Partition(7) });
  Receive(conversation, 2, protocol::ErrorAnswer{ 409, "no model is open", std::nullopt });
  Receive(conversation, 3, protocol::EndAnswer{}); // the end, without the blob
  Receive(conversation, 99, protocol::ErrorAnswer{ 404, "nobody asked", std::nullopt });
  const auto events = conversation.TakeEvents();
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, EventKind::BlobFailed);
  EXPECT_EQ(events[0].message, "damaged");
  EXPECT_EQ(events[1].kind, EventKind::RequestFailed);
  EXPECT_EQ(events[1].request, 2u);
  EXPECT_EQ(events[2].kind, EventKind::RequestEnded);
  EXPECT_EQ(events[2].request, 3u);
}

TEST(TestStreamConversation, ACancelEndsARequestWithoutAnswers)
{
  StreamConversation conversation;
  conversation.Send(Partitions(1, 2), 0);
  conversation.TakeMessages();
  SessionRequest cancel;
  cancel.kind = Kind::Cancel;
  cancel.id = 1;
  conversation.Send(cancel, 0);
  conversation.Send(cancel, 0); // a second cancel does no harm
  const auto messages = Parse(conversation.TakeMessages());
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<protocol::CancelRequest>(messages[0].body));
  EXPECT_EQ(messages[0].request, 1u);
  ReceiveBlob(conversation, 1, BlobId::Partition(0));
  Receive(conversation, 1, protocol::EndAnswer{ 1, 3, 0, true });
  EXPECT_TRUE(conversation.TakeEvents().empty());
  EXPECT_FALSE(conversation.IsWaiting());
  // A cancelled request that still waits is never sent.
  for (std::uint32_t id = 2; id < 2 + 2 * StreamConversation::mostUnfinished; ++id)
  {
    conversation.Send(Partitions(id, 1, id), 0);
  }
  EXPECT_EQ(conversation.TakeMessages().size(), StreamConversation::mostUnfinished);
  cancel.id = 2 * StreamConversation::mostUnfinished;
  conversation.Send(cancel, 0);
  EXPECT_TRUE(conversation.TakeMessages().empty());
}

TEST(TestStreamConversation, ANewConnectionGoesOnWhereTheOldOneEnded)
{
  StreamConversation conversation;
  conversation.Send(OpenModel(1, "m"), 0);
  Receive(conversation, 1, protocol::OpenedAnswer{ Model('a') });
  conversation.Send(Partitions(2, 3), 0);
  ReceiveBlob(conversation, 2, BlobId::Partition(1));
  conversation.TakeMessages();
  conversation.TakeEvents();
  conversation.Restart(0);
  const auto messages = Parse(conversation.TakeMessages());
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(std::get<protocol::OpenRequest>(messages[0].body).model, "m");
  EXPECT_EQ(std::get<protocol::BlobsRequest>(messages[1].body).blobs,
    (std::vector{ BlobId::Partition(0), BlobId::Partition(2) }));
  Receive(conversation, messages[0].request, protocol::OpenedAnswer{ Model('a') });
  EXPECT_TRUE(conversation.TakeEvents().empty()); // for the session it is open already
  ReceiveBlob(conversation, messages[1].request, BlobId::Partition(0));
  EXPECT_EQ(conversation.TakeEvents().size(), 1u);
}

// A region is requested from the tap outwards; so is the rest of it after a lost connection.
TEST(TestStreamConversation, ANewConnectionAsksInTheOrderOfTheRequest)
{
  StreamConversation conversation;
  SessionRequest region = Partitions(1, 0);
  for (const std::uint32_t partition : { 8, 9, 3, 40, 2, 21 }) // nearest first
  {
    region.blobs.push_back(BlobId::Partition(partition));
  }
  conversation.Send(region, 0);
  ReceiveBlob(conversation, 1, BlobId::Partition(8));
  ReceiveBlob(conversation, 1, BlobId::Partition(3));
  conversation.TakeMessages();
  conversation.Restart(0);
  const auto messages = Parse(conversation.TakeMessages());
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(std::get<protocol::BlobsRequest>(messages[0].body).blobs,
    (std::vector{
      BlobId::Partition(9), BlobId::Partition(40), BlobId::Partition(2), BlobId::Partition(21) }));
}

TEST(TestStreamConversation, AnotherBuildOfTheModelIsNotMixedWithTheFirst)
{
  StreamConversation conversation;
  conversation.Send(OpenModel(1, "m"), 0);
  Receive(conversation, 1, protocol::OpenedAnswer{ Model('a') });
  conversation.Send(Partitions(2, 3), 0);
  conversation.TakeEvents();
  conversation.TakeMessages();
  conversation.Restart(0);
  const auto messages = Parse(conversation.TakeMessages());
  Receive(conversation, messages[0].request, protocol::OpenedAnswer{ Model('b') });
  ReceiveBlob(conversation, messages[1].request, BlobId::Partition(0));
  conversation.Send(Partitions(3, 1), 0);
  const auto events = conversation.TakeEvents();
  ASSERT_EQ(events.size(), 2u);
  for (const ClientEvent& event : events)
  {
    EXPECT_EQ(event.kind, EventKind::RequestFailed);
    EXPECT_NE(event.message.find("replaced"), std::string::npos);
  }
  // The model may be opened again.
  conversation.TakeMessages();
  conversation.Send(OpenModel(4, "m"), 0);
  const auto again = Parse(conversation.TakeMessages());
  ASSERT_EQ(again.size(), 1u);
  Receive(conversation, again[0].request, protocol::OpenedAnswer{ Model('b') });
  EXPECT_EQ(conversation.TakeEvents().at(0).kind, EventKind::Opened);
}

TEST(TestStreamConversation, NonsenseEndsTheConnectionNotTheProgram)
{
  StreamConversation conversation;
  conversation.Send(Partitions(1, 1), 0);
  EXPECT_FALSE(conversation.ReceiveText("{", 0));
  EXPECT_FALSE(conversation.ReceiveText(
    protocol::WriteServerMessage({ 0, protocol::ErrorAnswer{ 400, "malformed", {} } }), 0));
  EXPECT_FALSE(conversation.ReceiveFrame(std::vector<std::uint8_t>{ 1, 2, 3 }, 0));
  const std::vector<std::uint8_t> payload{ 1, 2 };
  EXPECT_FALSE(conversation.ReceiveFrame(
    protocol::EncodeFrame({ 1, BlobId::Partition(0), 1, 3 }, payload), 0)); // after a gap
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i)
  {
    std::vector<std::uint8_t> bytes(random() % 60);
    for (auto& byte : bytes)
    {
      byte = static_cast<std::uint8_t>(random() % 4);
    }
    (void)conversation.ReceiveFrame(bytes, 0);
    (void)conversation.ReceiveText(
      { reinterpret_cast<const char*>(bytes.data()), bytes.size() }, 0);
  }
  conversation.FailAll("lost");
  EXPECT_FALSE(conversation.IsWaiting());
  EXPECT_EQ(conversation.TakeEvents().back().message, "lost");
}

}
