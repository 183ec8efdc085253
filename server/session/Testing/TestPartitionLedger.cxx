// SPDX-License-Identifier: BSD-3-Clause
// Quotas and records of the original, seen from a conversation.
#include "server/session/PartitionLedger.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/access/Testing/ForgedToken.h"
#include "server/session/Conversation.h"
#include "server/session/Testing/MemoryCatalog.h"
#include "server/session/Testing/PullMessage.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

class Ledger : public testing::Test
{
protected:
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 5, 100); // 32 partitions
  const fixtures::TemporaryFolder folder;
  std::int64_t time = 1000;
  std::shared_ptr<TokenGuard> guard =
    std::make_shared<TokenGuard>(forged::Keys(), [this] { return this->time; });
  std::vector<PartitionRecord> records;
  int refusals = 0;

  std::shared_ptr<PartitionLedger> With(const QuotaLimits& limits)
  {
    auto book = QuotaBook::Open(
      this->folder.Path / "quotas.db", limits, [this] { return this->time * 1'000'000; });
    EXPECT_TRUE(book);
    return std::make_shared<PartitionLedger>(
      std::move(*book), [this](const PartitionRecord& record) { this->records.push_back(record); },
      [this] { ++this->refusals; });
  }
  Permission Ann(std::shared_ptr<PartitionLedger> ledger)
  {
    const auto pass = this->guard->Admit(forged::Token(
      forged::header, R"({"sub":"ann","jti":"t1","exp":9000,"models":"*","detail":"regions"})"));
    EXPECT_TRUE(pass);
    return { this->guard, *pass, std::move(ledger), "10.1.1.1" };
  }

  struct Heard
  {
    std::set<std::uint32_t> partitions;
    std::optional<ErrorAnswer> error;
    bool ended = false;
  };
  // Everything that answers the request.
  static Heard Ask(Conversation& conversation, const ClientMessage& message)
  {
    conversation.Receive(WriteClientMessage(message));
    Heard heard;
    while (auto next = PullMessage(conversation))
    {
      if (const auto* frame = std::get_if<std::vector<std::uint8_t>>(&*next))
      {
        heard.partitions.insert(ParseFrame(*frame)->header.blob.number);
        continue;
      }
      const auto answer = ParseServerMessage(std::get<std::string>(*next));
      if (const auto* error = std::get_if<ErrorAnswer>(&answer->body))
      {
        heard.error = *error;
      }
      heard.ended = heard.ended || std::holds_alternative<EndAnswer>(answer->body);
    }
    return heard;
  }
};

QuotaLimits Share(double share)
{
  QuotaLimits limits;
  limits.share = share;
  limits.window = std::chrono::seconds(100);
  return limits;
}

}

// The quota counts in the same way whether a blob has to be read or is in memory.
TEST_F(Ledger, AConversationGetsItsShareAndANoticeWhenThereIsMore)
{
  for (const bool inMemory : { false, true })
  {
    this->model->inMemory = inMemory;
    this->time += 1000;
    this->refusals = 0;
    this->records.clear();
    const auto ledger = this->With(Share(0.25)); // 8 of 32
    Conversation conversation(this->catalog, ConversationLimits(), this->Ann(ledger));
    Ask(conversation, { 1, OpenRequest{ "dragon" } });
    const auto heard = Ask(conversation, { 2, RegionRequest{ 1, 3, {} } });
    EXPECT_EQ(heard.partitions.size(), 8u);
    ASSERT_TRUE(heard.error);
    EXPECT_EQ(heard.error->code, 403);
    EXPECT_FALSE(heard.error->blob) << "of the whole request";
    EXPECT_NE(heard.error->message.find("the quota of 8 partitions"), std::string::npos);
    EXPECT_NE(heard.error->message.find(": try again at 1970-"), std::string::npos);
    EXPECT_FALSE(heard.ended);
    EXPECT_EQ(this->refusals, 1);

    // Partitions that the client has had may be requested again, and blobs that are not of the
    // original do not count.
    const std::vector<std::uint32_t> had(heard.partitions.begin(), heard.partitions.end());
    EXPECT_EQ(Ask(conversation, { 3, AskPartitions(had) }).partitions, heard.partitions);
    EXPECT_TRUE(Ask(conversation, { 4, AskPieces(0, { 1 }) }).ended);
    this->time += 100;
    EXPECT_TRUE(Ask(conversation, { 5, AskPartitions({ 0, 31 }) }).ended);
  }
}

TEST_F(Ledger, RegionsAreCounted)
{
  QuotaLimits limits;
  limits.regionsPerMinute = 1;
  Conversation conversation(this->catalog, ConversationLimits(), this->Ann(this->With(limits)));
  Ask(conversation, { 1, OpenRequest{ "dragon" } });
  EXPECT_TRUE(Ask(conversation, { 2, RegionRequest{ 32, 0, {} } }).ended);
  const auto heard = Ask(conversation, { 3, RegionRequest{ 33, 0, {} } });
  ASSERT_TRUE(heard.error);
  EXPECT_EQ(heard.error->code, 429) << "to be asked for again soon";
  EXPECT_TRUE(heard.partitions.empty());
}

TEST_F(Ledger, EveryPartitionIsRecorded)
{
  Conversation conversation(this->catalog, ConversationLimits(), this->Ann(this->With({})));
  Ask(conversation, { 1, OpenRequest{ "dragon" } });
  Ask(conversation, { 2, BlobsRequest{ { BlobId::LevelPiece(0, 1), BlobId::Partition(7) } } });
  this->model->damaged = { BlobId::Partition(8) };
  Ask(conversation, { 3, AskPartitions({ 8 }) });
  ASSERT_EQ(this->records.size(), 1u) << "those that are sent alone";
  const auto& record = this->records.front();
  EXPECT_EQ(record.subject, "ann");
  EXPECT_EQ(record.token, "t1");
  EXPECT_EQ(record.client, "10.1.1.1");
  EXPECT_EQ(record.model, "dragon");
  EXPECT_EQ(record.digest, this->model->Description().digest);
  EXPECT_EQ(record.partition, 7u);
  EXPECT_EQ(record.bytes, this->model->blobs.at(BlobId::Partition(7))->size());
}

// However the model is built again, with another precision or other texts, it has the same
// original.
TEST_F(Ledger, BuildsOfOneInputAreOneOriginal)
{
  const auto ledger = this->With(Share(0.25)); // 8 of 32
  ModelDescription builds[] = { this->model->Description(), this->model->Description() };
  builds[0].inputDigest = builds[1].inputDigest = std::string(32, 'a');
  builds[1].digest = std::string(32, 'b');
  builds[1].grid.bits = 8;
  builds[1].title = "another";
  const auto may = [&](const ModelDescription& build, std::uint32_t partition)
  {
    PartitionRecord record;
    record.subject = "ann";
    record.partition = partition;
    return !ledger->TakePartition(build, record);
  };
  for (std::uint32_t partition = 0; partition < 8; ++partition)
  {
    EXPECT_TRUE(may(builds[partition % 2], partition));
    EXPECT_TRUE(may(builds[1 - partition % 2], partition)) << "which she has";
  }
  EXPECT_FALSE(may(builds[0], 8));
  EXPECT_FALSE(may(builds[1], 8));
  ASSERT_EQ(this->records.size(), 16u);
  for (const auto& record : this->records)
  {
    EXPECT_EQ(record.original, builds[0].inputDigest) << "for who reads the audit log";
  }
  // A build with more, smaller partitions of the same input; and a store that does not name its
  // input.
  ModelDescription finer = builds[0], another = builds[0];
  finer.digest = std::string(32, 'c');
  finer.partitions *= 2;
  EXPECT_FALSE(may(finer, 0));
  another.digest = std::string(32, 'd');
  another.inputDigest.clear();
  EXPECT_TRUE(may(another, 9));
  EXPECT_EQ(this->records.back().original, another.digest);
}
