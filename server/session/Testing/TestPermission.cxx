// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Permission.h"

#include "filters/model/ModelJson.h"
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

// Two models, and a client with a token for one of them.
class Access : public testing::Test
{
protected:
  MemoryCatalog catalog;
  // Its partition depth is 12, which is deeper than the preview.
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 12, 100);
  std::int64_t time = 1000;
  std::shared_ptr<TokenGuard> guard =
    std::make_shared<TokenGuard>(forged::Keys(), [this] { return this->time; });

  void SetUp() override { this->catalog.Add("vase", 2, 3, 100); }

  Permission For(const std::string& detail) const
  {
    const auto pass = this->guard->Admit(forged::Token(forged::header,
      R"({"sub":"ann","exp":2000,"models":["dragon"],"detail":")" + detail + "\"}"));
    EXPECT_TRUE(pass);
    return { this->guard, *pass };
  }
  unsigned StatusOf(const std::string& detail, const BlobId& blob) const
  {
    const auto refused = this->For(detail).RefuseBlob(this->model->Description(), blob);
    return refused ? refused->status : 200;
  }
  Conversation ConversationTest(const std::string& detail) const
  {
    return Conversation(this->catalog, ConversationLimits(), this->For(detail));
  }

  // The errors and ends of requests, and the blobs that were received.
  struct Heard
  {
    std::map<std::uint32_t, unsigned> errors; // code by request
    std::set<std::uint32_t> ended;
    std::set<BlobId> blobs;
  };
  static Heard Listen(Conversation& conversation)
  {
    Heard heard;
    while (auto message = PullMessage(conversation))
    {
      if (const auto* frame = std::get_if<std::vector<std::uint8_t>>(&*message))
      {
        heard.blobs.insert(ParseFrame(*frame)->header.blob);
        continue;
      }
      const auto answer = ParseServerMessage(std::get<std::string>(*message));
      if (const auto* error = std::get_if<ErrorAnswer>(&answer->body))
      {
        heard.errors[answer->request] = error->code;
      }
      else if (std::holds_alternative<EndAnswer>(answer->body))
      {
        heard.ended.insert(answer->request);
      }
    }
    return heard;
  }
  static void Ask(Conversation& conversation, const ClientMessage& message)
  {
    conversation.Receive(WriteClientMessage(message));
  }
  static void Open(Conversation& conversation)
  {
    Ask(conversation, { 1, OpenRequest{ "dragon" } });
    EXPECT_TRUE(Listen(conversation).errors.empty());
  }
};

}

TEST_F(Access, EachDetailHasItsBlobs)
{
  ASSERT_EQ(PreviewLevel(this->model->Description()), 11u);
  const auto box = BlobId::PartitionBoxes(1u << 7);
  const auto deepPage = BlobId::TreePage(1u << 7); // describes the depths down to 12
  EXPECT_EQ(this->StatusOf("preview", BlobId::LevelPiece(11, 1)), 200u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::LevelPiece(0, 1)), 200u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::LevelPiece(12, 2)), 403u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::LevelTexture(11, 1)), 200u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::LevelTexture(12, 2)), 403u);
  EXPECT_EQ(this->StatusOf("levels", BlobId::LevelTexture(12, 2)), 200u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::TreePage(1)), 403u) << "it tells of level 12";
  EXPECT_EQ(this->StatusOf("preview", deepPage), 403u);
  EXPECT_EQ(this->StatusOf("preview", box), 403u);
  EXPECT_EQ(this->StatusOf("preview", BlobId::Partition(0)), 403u);

  EXPECT_EQ(this->StatusOf("levels", BlobId::LevelPiece(12, 2)), 200u);
  EXPECT_EQ(this->StatusOf("levels", BlobId::TreePage(1)), 200u);
  EXPECT_EQ(this->StatusOf("levels", deepPage), 200u);
  EXPECT_EQ(this->StatusOf("levels", box), 403u);
  EXPECT_EQ(this->StatusOf("levels", BlobId::Partition(0)), 403u);
  EXPECT_EQ(this->StatusOf("levels", BlobId::Texture(0)), 403u);

  EXPECT_EQ(this->StatusOf("regions", box), 200u);
  EXPECT_EQ(this->StatusOf("regions", BlobId::Partition(0)), 200u);
  EXPECT_EQ(this->StatusOf("regions", BlobId::Texture(0)), 200u);
  EXPECT_FALSE(Permission().RefuseBlob(this->model->Description(), BlobId::Partition(0)));
}

TEST_F(Access, OtherModelsAreRefusedWhetherTheyAreThereOrNot)
{
  const auto permission = this->For("regions");
  EXPECT_FALSE(permission.RefuseModel("dragon"));
  for (const std::string name : { "vase", "lucy" })
  {
    const auto refused = permission.RefuseModel(name);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 403);
    EXPECT_EQ(refused->message, "the token is not for the model " + name);
    auto conversation = this->ConversationTest("regions");
    Ask(conversation, { 1, OpenRequest{ name } });
    EXPECT_EQ(Listen(conversation).errors[1], 403u);
  }
  EXPECT_TRUE(
    permission.RefuseBlob(this->catalog.Find("vase")->Description(), BlobId::LevelPiece(0, 1)));
}

TEST_F(Access, AConversationGivesWhatTheTokenAllows)
{
  const std::vector<ClientMessage> messages{ { 2, AskPieces(11, { 1 }) },
    { 3, BlobsRequest{ { BlobId::TreePage(1) } } }, { 4, AskPieces(12, { 2, 3 }) },
    { 5, BlobsRequest{ { BlobId::LevelPiece(12, 2) } } }, { 6, RegionRequest{ 1u << 12, 1, {} } },
    { 7, AskPartitions({ 0 }) }, { 8, BlobsRequest{ { BlobId::PartitionBoxes(1u << 7) } } },
    { 9, BlobsRequest{ { BlobId::LevelPiece(0, 1), BlobId::Partition(3) } } } };
  const std::map<std::string, std::uint32_t> first{ { "preview", 3 }, { "levels", 6 },
    { "regions", 10 } }; // the first request that is refused; all later ones are, too
  for (const auto& [detail, firstRefused] : first)
  {
    auto conversation = this->ConversationTest(detail);
    Open(conversation);
    for (const auto& message : messages)
    {
      Ask(conversation, message);
      const auto heard = Listen(conversation);
      const bool refused = message.request >= firstRefused;
      EXPECT_EQ(
        heard.errors.count(message.request) && heard.errors.at(message.request) == 403, refused)
        << detail << " " << message.request;
      EXPECT_TRUE(!refused || heard.blobs.empty()) << detail << " " << message.request;
    }
    EXPECT_TRUE(conversation.IsPermitted());
    EXPECT_FALSE(conversation.Closing());
  }
}

// Resolutions finer than the token allows are not listed either, neither by GET nor on a stream.
TEST_F(Access, ADescriptionHasNoMoreThanTheTokenAllows)
{
  const auto& all = this->model->Description();
  ASSERT_GT(all.levels.size(), 12u);
  for (const std::string detail : { "preview", "levels", "regions" })
  {
    auto conversation = this->ConversationTest(detail);
    Ask(conversation, { 1, OpenRequest{ "dragon" } });
    const auto answer = ParseServerMessage(std::get<std::string>(*PullMessage(conversation)));
    const auto& reported = std::get<OpenedAnswer>(answer->body).model;
    const auto json = this->model->Json(*ParseDetail(detail));
    EXPECT_EQ(reported, ParseModel(std::string(json->begin(), json->end())).Value());
    EXPECT_EQ(NameOf(reported.detail), detail);
    EXPECT_EQ(reported.depths, all.depths) << "by which pieces are read";
    for (std::size_t level = 0; level < all.levels.size(); ++level)
    {
      const bool isReported = detail != "preview" || level <= 11;
      EXPECT_EQ(reported.levels[level], isReported ? all.levels[level] : ResolutionDescription())
        << detail << " " << level;
    }
    EXPECT_EQ(reported.original, detail == "regions" ? all.original : ResolutionDescription());
  }
}

TEST_F(Access, AConversationEndsWithItsToken)
{
  auto conversation = this->ConversationTest("regions");
  Open(conversation);
  Ask(conversation, { 2, AskPartitions({ 0, 1, 2 }) });
  Ask(conversation, { 3, AskPartitions({ 4 }) });
  (void)PullMessage(conversation);                   // begin
  ASSERT_EQ(PullMessage(conversation)->index(), 1u); // a frame
  ASSERT_TRUE(PullMessage(conversation));
  this->time = 2000;
  EXPECT_FALSE(conversation.IsPermitted());
  const auto heard = Listen(conversation);
  EXPECT_EQ(heard.errors, (std::map<std::uint32_t, unsigned>{ { 2, 401 }, { 3, 401 } }));
  EXPECT_TRUE(heard.blobs.empty());
  EXPECT_EQ(conversation.Closing(), CloseReason::NotPermitted);
  Ask(conversation, { 4, AskPartitions({ 5 }) });
  EXPECT_FALSE(PullMessage(conversation));
}

TEST_F(Access, AnIdleConversationEndsToo)
{
  auto conversation = this->ConversationTest("regions");
  Open(conversation);
  auto keys = forged::Keys();
  keys.revokedSubjects = { "ann" };
  EXPECT_TRUE(conversation.IsPermitted());
  this->guard->Replace(keys);
  EXPECT_FALSE(conversation.IsPermitted());
  EXPECT_EQ(Listen(conversation).errors, (std::map<std::uint32_t, unsigned>{ { 0, 401 } }));
  EXPECT_EQ(conversation.Closing(), CloseReason::NotPermitted);
}

// A blob that is being read when the token expires is not sent.
TEST_F(Access, ABlobThatIsReadForAnExpiredTokenStaysHere)
{
  auto conversation = this->ConversationTest("regions");
  Open(conversation);
  Ask(conversation, { 2, AskPartitions({ 0 }) });
  ASSERT_TRUE(conversation.NextMessage()); // begin
  EXPECT_FALSE(conversation.NextMessage());
  const auto task = conversation.TakeTask();
  ASSERT_TRUE(task);
  task->Run();
  this->time = 2000;
  conversation.Finish(task);
  const auto heard = Listen(conversation);
  EXPECT_TRUE(heard.blobs.empty());
  EXPECT_EQ(heard.errors.at(2), 401u);
}
