// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "server/session/Conversation.h"

#include "filters/core/tree/Region.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/session/Testing/MemoryCatalog.h"
#include "server/session/Testing/PullMessage.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

// A conversation and its client.
class ConversationTest : public testing::Test
{
protected:
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 7, 20000);
  Conversation conversation{ this->catalog };
  FrameAssembler assembler;
  std::vector<FrameAssembler::Blob> blobs;
  std::vector<ServerMessage> answers;

  void Ask(const ClientMessage& message)
  {
    this->conversation.Receive(WriteClientMessage(message));
  }

  // Takes one message; false if there is none.
  bool Step()
  {
    const auto message = PullMessage(this->conversation);
    if (!message)
    {
      return false;
    }
    if (const auto* text = std::get_if<std::string>(&*message))
    {
      auto answer = ParseServerMessage(*text);
      EXPECT_TRUE(answer) << *text;
      this->answers.push_back(std::move(*answer));
      return true;
    }
    const auto& bytes = std::get<std::vector<std::uint8_t>>(*message);
    EXPECT_LE(bytes.size(), maximumFrameBytes);
    const auto frame = ParseFrame(bytes);
    EXPECT_TRUE(frame);
    auto blob = this->assembler.Accept(*frame);
    EXPECT_TRUE(blob);
    if (*blob)
    {
      this->blobs.push_back(std::move(**blob));
    }
    return true;
  }

  void Finish()
  {
    while (this->Step())
    {
    }
  }

  void OpenModel()
  {
    this->Ask({ 1, OpenRequest{ "dragon" } });
    this->Finish();
    ASSERT_EQ(this->answers.size(), 1u);
    ASSERT_EQ(std::get<OpenedAnswer>(this->answers[0].body).model, this->model->Description());
    this->answers.clear();
  }

  template <class Answer>
  const Answer& Last() const
  {
    static const Answer none{};
    const auto* answer =
      this->answers.empty() ? nullptr : std::get_if<Answer>(&this->answers.back().body);
    EXPECT_TRUE(answer) << "the last answer is another one";
    return answer ? *answer : none;
  }

  // Expects that the request is answered by an error and nothing else.
  void ExpectError(const ClientMessage& message, unsigned code)
  {
    this->answers.clear();
    this->blobs.clear();
    this->Ask(message);
    this->Finish();
    ASSERT_EQ(this->answers.size(), 1u);
    EXPECT_EQ(this->answers[0].request, message.request);
    EXPECT_EQ(this->Last<ErrorAnswer>().code, code) << this->Last<ErrorAnswer>().message;
    EXPECT_FALSE(this->Last<ErrorAnswer>().blob);
    EXPECT_TRUE(this->blobs.empty());
    EXPECT_FALSE(this->conversation.Closing());
  }

  // Expects that the model can be opened, or that it is being replaced.
  void ExpectOpened(std::uint32_t request, bool opened)
  {
    this->answers.clear();
    this->Ask({ request, OpenRequest{ "dragon" } });
    this->Finish();
    ASSERT_EQ(this->answers.size(), 1u);
    const auto& body = this->answers[0].body;
    EXPECT_EQ(std::holds_alternative<OpenedAnswer>(body), opened);
    EXPECT_TRUE(opened || std::get<ErrorAnswer>(body).code == 503);
  }

  void ExpectBlobs(std::uint32_t request, const std::vector<BlobId>& expected)
  {
    ASSERT_EQ(this->blobs.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
    {
      EXPECT_EQ(this->blobs[i].request, request);
      EXPECT_EQ(this->blobs[i].id, expected[i]) << BlobName(this->blobs[i].id);
      EXPECT_EQ(this->blobs[i].bytes, *this->model->blobs.at(expected[i]));
    }
  }
};

std::vector<BlobId> Partitions(const std::vector<std::uint32_t>& numbers)
{
  std::vector<BlobId> ids;
  for (const auto number : numbers)
  {
    ids.push_back(BlobId::Partition(number));
  }
  return ids;
}

}

TEST_F(ConversationTest, BlobsComeInTheOrderAskedFor)
{
  this->OpenModel();
  const std::vector<BlobId> some{ BlobId::TreePage(1), BlobId::Partition(9),
    BlobId::LevelPiece(0, 1), BlobId::Partition(2), BlobId::Partition(127),
    BlobId::LevelPiece(0, 1) };
  this->Ask({ 2, BlobsRequest{ some } });
  this->Finish();
  this->ExpectBlobs(2, some);
  EXPECT_EQ(std::get<BeginAnswer>(this->answers.front().body).blobs, some.size());
  std::uint64_t bytes = 0;
  for (const auto& blob : this->blobs)
  {
    bytes += blob.bytes.size();
  }
  EXPECT_EQ(this->Last<EndAnswer>(), (EndAnswer{ some.size(), bytes, 0, false }));
}

// In an earlier version of the protocol each kind of blob had its own message.
TEST_F(ConversationTest, MessagesOfBeforeAreRefusedWithWhatToSendInstead)
{
  this->OpenModel();
  std::uint32_t request = 1;
  for (const std::string rest : { R"("preview"})", R"("level","level":0,"nodes":[1]})",
         R"("tree","nodes":[1]})", R"("boxes","nodes":[1]})", R"("partitions","partitions":[1]})" })
  {
    this->answers.clear();
    this->conversation.Receive("{\"request\":" + std::to_string(++request) + ",\"type\":" + rest);
    this->Finish();
    ASSERT_EQ(this->answers.size(), 1u) << rest;
    EXPECT_EQ(this->answers[0].request, request);
    EXPECT_EQ(this->Last<ErrorAnswer>().code, 400);
    EXPECT_NE(this->Last<ErrorAnswer>().message.find("\"blobs\""), std::string::npos)
      << this->Last<ErrorAnswer>().message;
    EXPECT_FALSE(this->conversation.Closing());
  }
}

TEST_F(ConversationTest, RegionsComeInTheOrderOfFindRegion)
{
  this->OpenModel();
  RandomMessages random(3);
  for (std::uint32_t request = 2; request < 60; ++request)
  {
    const auto cell = random.Small<std::uint32_t>(1, 255);
    const auto rings = random.Small<std::uint8_t>(0, 3);
    const auto expected =
      FindRegion(this->model->TrueBoxes(), this->model->GetDepths(), cell, rings);
    ASSERT_TRUE(expected);
    std::vector<std::uint32_t> held;
    std::vector<std::uint32_t> wanted;
    for (const auto partition : *expected)
    {
      (random.Integer(0, 3) == 0 ? held : wanted).push_back(partition);
    }
    this->blobs.clear();
    this->answers.clear();
    this->Ask({ request, RegionRequest{ cell, rings, held } });
    this->Finish();
    this->ExpectBlobs(request, Partitions(wanted));
    const auto& begin = std::get<BeginAnswer>(this->answers.front().body);
    EXPECT_EQ(begin.blobs, wanted.size());
    EXPECT_EQ(begin.partitions, *expected);
    EXPECT_EQ(this->Last<EndAnswer>().blobs, wanted.size());
  }
}

TEST_F(ConversationTest, WhatTheModelDoesNotHaveIsAnErrorOfTheRequest)
{
  this->ExpectError({ 1, AskPieces(0, { 1 }) }, 409); // no model is open
  this->ExpectError({ 1, OpenRequest{ "lucy" } }, 404);
  this->answers.clear();
  this->OpenModel();
  const auto finest = this->model->Description().depths.finest;
  this->ExpectError({ 2, AskPieces(static_cast<std::uint8_t>(finest + 1), { 1 }) }, 404);
  this->ExpectError({ 3, AskPieces(3, { 2 }) }, 404);
  this->ExpectError({ 4, BlobsRequest{ { BlobId::TreePage(2) } } }, 404);
  this->ExpectError({ 5, BlobsRequest{ { BlobId::TreePage(1u << 11) } } }, 404);
  this->ExpectError({ 5, BlobsRequest{ { BlobId::PartitionBoxes(1u << 11) } } }, 404);
  this->ExpectError({ 6, AskPartitions({ 0, 128 }) }, 404);
  this->ExpectError({ 7, RegionRequest{ 256, 1, {} } }, 400);
  this->answers.clear();
  this->Ask({ 8, AskPieces(0, { 1 }) }); // the conversation continues
  this->Finish();
  EXPECT_EQ(this->Last<EndAnswer>().blobs, 1u);
}

TEST_F(ConversationTest, WrongMessagesAreErrorsAndOthersEndIt)
{
  this->conversation.Receive(R"({"type":"dance","request":12})");
  this->conversation.Receive(R"({"type":"preview"})");
  this->Finish();
  ASSERT_EQ(this->answers.size(), 2u);
  EXPECT_EQ(this->answers[0].request, 12u);
  EXPECT_EQ(this->answers[1].request, 0u);
  EXPECT_FALSE(this->conversation.Closing());

  const std::pair<std::string, CloseReason> fatal[] = { { "nonsense", CloseReason::NotJson },
    { "[1]", CloseReason::NotJson }, { std::string(5000, ' '), CloseReason::TooLarge } };
  for (const auto& [text, reason] : fatal)
  {
    Conversation other(catalog);
    other.Receive(WriteClientMessage({ 1, OpenRequest{ "dragon" } }));
    other.Receive(text);
    EXPECT_EQ(other.Closing(), reason);
    EXPECT_FALSE(other.AcceptsMessages());
    other.Receive(WriteClientMessage({ 2, AskPieces(0, { 1 }) }));
    const auto last = PullMessage(other); // the error, and nothing after it
    ASSERT_TRUE(last);
    EXPECT_EQ(ParseServerMessage(std::get<std::string>(*last))->request, 0u);
    EXPECT_FALSE(PullMessage(other));
  }
  this->conversation.ReceiveBinary();
  EXPECT_EQ(this->conversation.Closing(), CloseReason::NotText);
}

TEST_F(ConversationTest, MessagesListsAndRequestsHaveTheSizesThatItIsGiven)
{
  ConversationLimits limits;
  limits.message.bytes = 8192;
  limits.message.listed = 3;
  limits.requests = 2;
  Conversation other(this->catalog, limits);
  const auto errorTo = [&other](const std::string& text)
  {
    other.Receive(text);
    const auto message = other.NextMessage();
    if (!message)
    {
      return std::string("none");
    }
    const auto answer = ParseServerMessage(std::get<std::string>(*message));
    const auto* error = std::get_if<ErrorAnswer>(&answer->body);
    return error ? std::to_string(error->code) + " " + error->message : "no error";
  };
  const auto open = WriteClientMessage({ 1, OpenRequest{ "dragon" } });
  EXPECT_EQ(errorTo(open + std::string(8192 - open.size(), ' ')), "none") << "it is opened";
  EXPECT_EQ(errorTo(WriteClientMessage({ 2, AskPartitions({ 1, 2, 3 }) })), "none");
  EXPECT_TRUE(
    fixtures::Mentions(errorTo(WriteClientMessage({ 3, AskPieces(0, { 1 }) })), { "429 ", " 2 " }));
  for (const auto& list : { WriteClientMessage({ 4, AskPartitions({ 1, 2, 3, 4 }) }),
         WriteClientMessage({ 4, RegionRequest{ 1, 1, { 1, 2, 3, 4 } } }),
         WriteClientMessage({ 4, BlobsRequest{ std::vector(4, BlobId::Partition(1)) } }) })
  {
    EXPECT_EQ(errorTo(list).substr(0, 4), "400 ") << list;
  }
  EXPECT_EQ(errorTo(std::string(8193, ' ')).substr(0, 4), "413 ");
  EXPECT_EQ(other.Closing(), CloseReason::TooLarge);
}

TEST_F(ConversationTest, CancelStopsTheCurrentRequestAtOnce)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 0, 1, 2, 3, 4, 5, 6, 7 }) });
  while (this->blobs.size() < 2)
  {
    ASSERT_TRUE(this->Step());
  }
  const auto reads = this->model->reads.load();
  this->Ask({ 2, CancelRequest{} });
  ASSERT_TRUE(this->Step());
  EXPECT_TRUE(this->Last<EndAnswer>().cancelled);
  EXPECT_EQ(this->Last<EndAnswer>().blobs, 2u);
  EXPECT_FALSE(this->Step());
  EXPECT_EQ(this->blobs.size(), 2u);
  EXPECT_EQ(this->model->reads.load(), reads) << "nothing is read for a cancelled request";

  this->answers.clear();
  this->Ask({ 2, AskPieces(0, { 1 }) }); // the id is free again
  this->Ask({ 99, CancelRequest{} });    // nobody's: ignored
  this->Finish();
  EXPECT_EQ(this->answers.size(), 2u);
  EXPECT_EQ(this->Last<EndAnswer>().blobs, 1u);
}

TEST_F(ConversationTest, CancelInTheMiddleOfABlob)
{
  this->OpenModel();
  auto& blob = this->model->blobs[BlobId::Partition(5)];
  const auto before = blob;
  blob = std::make_shared<const std::vector<std::uint8_t>>(300000, std::uint8_t{ 1 });
  this->Ask({ 2, AskPartitions({ 5 }) });
  ASSERT_TRUE(this->Step()); // begin
  ASSERT_TRUE(this->Step()); // a frame
  this->Ask({ 2, CancelRequest{} });
  this->Finish();
  EXPECT_EQ(this->Last<EndAnswer>(), (EndAnswer{ 0, maximumPayloadBytes, 0, true }));
  EXPECT_TRUE(this->blobs.empty());
  blob = before;
}

TEST_F(ConversationTest, ListensWhileATaskIsDone)
{
  this->OpenModel();
  this->Ask({ 2, RegionRequest{ 1, 1, {} } });
  EXPECT_FALSE(this->conversation.NextMessage());
  const auto search = this->conversation.TakeTask();
  ASSERT_TRUE(search);
  EXPECT_FALSE(this->conversation.TakeTask()) << "once";
  this->Ask({ 2, AskPieces(0, { 1 }) });
  EXPECT_TRUE(this->conversation.NextMessage()) << "2 is not finished yet";
  this->Ask({ 2, CancelRequest{} });
  search->Run();
  this->conversation.Finish(search);
  this->Finish();
  ASSERT_EQ(this->answers.size(), 1u);
  EXPECT_TRUE(this->Last<EndAnswer>().cancelled);
  EXPECT_EQ(this->model->reads.load(), 0u);
}

TEST_F(ConversationTest, ABlobOfACancelledRequestIsNotOneOfTheNextRequest)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 3 }) });
  EXPECT_TRUE(this->conversation.NextMessage()); // begin
  EXPECT_FALSE(this->conversation.NextMessage());
  const auto read = this->conversation.TakeTask();
  ASSERT_TRUE(read);
  this->Ask({ 2, CancelRequest{} });
  this->Ask({ 2, AskPartitions({ 4 }) });
  EXPECT_TRUE(this->conversation.NextMessage()); // end
  EXPECT_TRUE(this->conversation.NextMessage()); // begin
  read->Run();
  this->conversation.Finish(read);
  this->Finish();
  ASSERT_EQ(this->blobs.size(), 1u);
  EXPECT_EQ(this->blobs[0].id, BlobId::Partition(4));
  EXPECT_EQ(this->blobs[0].bytes, *this->model->blobs.at(BlobId::Partition(4)));
}

TEST_F(ConversationTest, WhatIsInMemoryNeedsNoTask)
{
  this->OpenModel();
  this->model->inMemory = true;
  this->Ask({ 2, AskPartitions({ 3, 4 }) });
  std::size_t messages = 0;
  while (this->conversation.NextMessage())
  {
    ++messages;
  }
  EXPECT_GE(messages, 4u);
  EXPECT_FALSE(this->conversation.TakeTask());
  EXPECT_EQ(this->model->reads.load(), 0u);
}

TEST_F(ConversationTest, RegionsHaveALimitedNumberOfPartitions)
{
  for (const std::size_t most : { std::size_t{ 127 }, std::size_t{ 128 } })
  {
    ConversationLimits limits;
    limits.partitions = most;
    Conversation other(this->catalog, limits);
    other.Receive(WriteClientMessage({ 1, OpenRequest{ "dragon" } }));
    PullMessage(other);
    other.Receive(WriteClientMessage({ 2, RegionRequest{ 1, 3, {} } }));
    const auto message = ParseServerMessage(std::get<std::string>(*PullMessage(other)));
    const auto* error = std::get_if<ErrorAnswer>(&message->body);
    EXPECT_EQ(error != nullptr, most == 127);
    EXPECT_TRUE(!error || error->code == 400);
  }
}

TEST_F(ConversationTest, WhoAsksTooOftenGetsAnErrorAndMayCancel)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 3 }) });
  this->conversation.Receive(
    WriteClientMessage({ 3, AskPieces(0, { 1 }) }), std::chrono::seconds(7));
  this->conversation.Receive(WriteClientMessage({ 2, CancelRequest{} }), std::chrono::seconds(7));
  this->Finish();
  ASSERT_EQ(this->answers.size(), 2u);
  EXPECT_EQ(std::get<ErrorAnswer>(this->answers[0].body).code, 429);
  EXPECT_EQ(
    std::get<ErrorAnswer>(this->answers[0].body).message, "too many requests: try again in 7 s");
  EXPECT_EQ(this->answers[0].request, 3u);
  EXPECT_TRUE(this->Last<EndAnswer>().cancelled);
}

TEST_F(ConversationTest, CancelOfAWaitingRequest)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 0 }) });
  this->Ask({ 3, AskPartitions({ 1 }) });
  this->Ask({ 4, AskPartitions({ 2 }) });
  this->Ask({ 3, CancelRequest{} });
  this->Finish();
  ASSERT_EQ(this->blobs.size(), 2u);
  EXPECT_EQ(this->blobs[0].request, 2u);
  EXPECT_EQ(this->blobs[1].request, 4u);
}

TEST_F(ConversationTest, AtMostSixteenUnfinishedRequests)
{
  this->OpenModel();
  for (std::uint32_t request = 1; request <= 17; ++request)
  {
    this->Ask({ request, AskPartitions({ request }) });
  }
  this->Ask({ 5, AskPieces(0, { 1 }) }); // the id of an unfinished request
  this->conversation.Receive(R"({"type":"dance","request":6})");
  ASSERT_TRUE(this->Step());
  EXPECT_EQ(this->answers.back().request, 17u);
  EXPECT_EQ(this->Last<ErrorAnswer>().code, 429);
  ASSERT_TRUE(this->Step());
  EXPECT_EQ(this->answers.back().request, 0u);
  EXPECT_EQ(this->Last<ErrorAnswer>().code, 409);
  ASSERT_TRUE(this->Step());
  EXPECT_EQ(this->answers.back().request, 0u);
  EXPECT_EQ(this->Last<ErrorAnswer>().code, 400);
  this->Finish();
  EXPECT_EQ(this->blobs.size(), 16u);
  EXPECT_EQ(this->conversation.Counted().tooMany, 1u);
  this->Ask({ 17, AskPartitions({ 17 }) });
  this->Finish();
  EXPECT_EQ(this->blobs.size(), 17u);
}

TEST_F(ConversationTest, ClientsThatDoNotReadAreDisconnected)
{
  int accepted = 0;
  for (; this->conversation.AcceptsMessages() && accepted < 100000; ++accepted)
  {
    this->conversation.Receive(R"({"type":"dance","request":1})");
  }
  EXPECT_EQ(accepted, static_cast<int>(Conversation::maximumPendingAnswers));
  this->Finish();
  EXPECT_TRUE(this->conversation.AcceptsMessages());
}

TEST_F(ConversationTest, DamagedBlobsAreErrorsAndTheRestComes)
{
  this->OpenModel();
  this->model->damaged = { BlobId::Partition(0), BlobId::Partition(2), BlobId::Partition(4) };
  this->Ask({ 2, AskPartitions({ 0, 1, 2, 3, 4 }) });
  this->Finish();
  this->model->damaged.clear();
  this->ExpectBlobs(2, Partitions({ 1, 3 }));
  std::vector<BlobId> named;
  for (const auto& answer : this->answers)
  {
    if (const auto* error = std::get_if<ErrorAnswer>(&answer.body))
    {
      EXPECT_EQ(error->code, 500);
      EXPECT_EQ(error->message.find("secret"), std::string::npos);
      named.push_back(error->blob.value_or(BlobId::TreePage(1)));
    }
  }
  EXPECT_EQ(named, Partitions({ 0, 2, 4 }));
  EXPECT_EQ(this->Last<EndAnswer>().blobs, 2u);
  EXPECT_EQ(this->Last<EndAnswer>().failed, 3u);
  EXPECT_EQ(this->conversation.Counted().failedBlobs, 3u);
}

TEST_F(ConversationTest, WhatMayPassIs503ForEachBlob)
{
  this->OpenModel();
  this->model->fails = ErrorCode::InputOutput;
  this->Ask({ 2, AskPartitions({ 0, 1 }) });
  this->Finish();
  ASSERT_EQ(this->answers.size(), 4u); // begin, two errors, end
  for (const std::size_t i : { 1, 2 })
  {
    const auto* error = std::get_if<ErrorAnswer>(&this->answers[i].body);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, 503);
    EXPECT_TRUE(error->blob);
  }
  EXPECT_EQ(this->Last<EndAnswer>().failed, 2u);
  this->ExpectOpened(3, true);
}

TEST_F(ConversationTest, AChangedStoreEndsTheRequest)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 0, 1, 2 }) });
  while (this->blobs.empty())
  {
    ASSERT_TRUE(this->Step());
  }
  this->model->fails = ErrorCode::Changed;
  this->Finish();
  EXPECT_EQ(this->Last<ErrorAnswer>().code, 410);
  EXPECT_FALSE(this->Last<ErrorAnswer>().blob);
  EXPECT_EQ(this->conversation.Counted().failedBlobs, 0u);
  this->ExpectOpened(2, false); // the id 2 is free again
  this->model->fails.reset();
  this->ExpectOpened(3, true);
}

TEST_F(ConversationTest, ADamagedTreeForbidsRegionsOnly)
{
  this->OpenModel();
  this->model->treeDamaged = true;
  this->ExpectError({ 2, RegionRequest{ 1, 1, {} } }, 500);
  this->model->treeDamaged = false;
  this->Ask({ 3, AskPieces(0, { 1 }) });
  this->Finish();
  EXPECT_EQ(this->Last<EndAnswer>().blobs, 1u);
}

TEST_F(ConversationTest, NothingIsReadBeforeItIsWanted)
{
  this->OpenModel();
  const auto before = this->model->reads.load();
  this->Ask({ 2, RegionRequest{ 1, 3, {} } });
  EXPECT_EQ(this->model->reads.load(), before);
  ASSERT_TRUE(this->Step()); // begin
  EXPECT_EQ(this->model->reads.load(), before);
  ASSERT_TRUE(this->Step());
  EXPECT_EQ(this->model->reads.load(), before + 1);
}

TEST_F(ConversationTest, ProgressComesAboutOnceAMebibyte)
{
  this->OpenModel();
  this->Ask({ 2, RegionRequest{ 1, 3, {} } }); // 128 partitions of about 20 kB
  this->Finish();
  std::uint64_t last = 0;
  int reports = 0;
  for (const auto& answer : this->answers)
  {
    if (const auto* progress = std::get_if<ProgressAnswer>(&answer.body))
    {
      EXPECT_GE(progress->bytes - last, 1u << 20);
      last = progress->bytes;
      ++reports;
    }
  }
  EXPECT_GE(reports, 2);
  EXPECT_EQ(this->Last<EndAnswer>().bytes, this->model->Description().original.bytes);
}

TEST_F(ConversationTest, KeepsTheModelThatItHasOpened)
{
  this->OpenModel();
  const auto old = this->model;
  this->model = catalog.Add("dragon", 2, 3, 1000);
  this->Ask({ 2, AskPartitions({ 100 }) }); // the new one has only 8
  this->Finish();
  ASSERT_EQ(this->blobs.size(), 1u);
  EXPECT_EQ(this->blobs[0].bytes, *old->blobs.at(BlobId::Partition(100)));
  this->answers.clear();
  this->OpenModel();
  this->ExpectError({ 3, AskPartitions({ 100 }) }, 404);
}

TEST_F(ConversationTest, DrainingFinishesTheCurrentRequestOnly)
{
  this->OpenModel();
  this->Ask({ 2, AskPartitions({ 0, 1, 2 }) });
  this->Ask({ 3, AskPieces(0, { 1 }) });
  ASSERT_TRUE(this->Step());
  ASSERT_TRUE(this->Step());
  this->conversation.Drain();
  this->Ask({ 4, AskPieces(0, { 1 }) });
  this->Finish();
  this->ExpectBlobs(2, Partitions({ 0, 1, 2 }));
  EXPECT_EQ(std::get<ErrorAnswer>(this->answers[1].body).code, 503);
  EXPECT_EQ(this->answers[1].request, 3u);
  EXPECT_EQ(this->answers[2].request, 4u);
  EXPECT_EQ(this->conversation.Closing(), CloseReason::GoingAway);
}

TEST_F(ConversationTest, RandomConversationsStayInOrder)
{
  RandomMessages random(12);
  for (int round = 0; round < 200; ++round)
  {
    Conversation other(catalog);
    std::size_t pulled = 0;
    for (int i = 0; i < 60; ++i)
    {
      auto message = random.FromClient();
      message.request = random.Small<std::uint32_t>(1, 20);
      if (auto* open = std::get_if<OpenRequest>(&message.body))
      {
        open->model = "dragon";
      }
      if (auto* region = std::get_if<RegionRequest>(&message.body))
      {
        region->cell = random.Small<std::uint32_t>(1, 300);
      }
      auto text = WriteClientMessage(message);
      other.Receive(random.Integer(0, 9) == 0 ? random.Mutated(text) : text);
      for (auto n = random.Integer(0, 5); n > 0; --n)
      {
        pulled += PullMessage(other) ? 1 : 0;
      }
    }
    while (PullMessage(other))
    {
      ASSERT_LT(++pulled, 100000u);
    }
    EXPECT_FALSE(PullMessage(other));
  }
}
