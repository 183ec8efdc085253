// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/ControlMessage.h"

#include "filters/protocol/Testing/RandomMessages.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

ErrorCode ClientError(const std::string& text)
{
  const auto message = ParseClientMessage(text);
  EXPECT_FALSE(message) << text;
  return message ? ErrorCode::Cancelled : message.GetError().code;
}

}

TEST(TestControlMessage, EveryMessageComesBack)
{
  RandomMessages random(10);
  for (int i = 0; i < 1000; ++i)
  {
    const auto fromClient = random.FromClient();
    const auto parsedClient = ParseClientMessage(WriteClientMessage(fromClient));
    ASSERT_TRUE(parsedClient) << parsedClient.GetError().message;
    EXPECT_EQ(*parsedClient, fromClient);
    const auto fromServer = random.FromServer();
    const auto parsedServer = ParseServerMessage(WriteServerMessage(fromServer));
    ASSERT_TRUE(parsedServer) << parsedServer.GetError().message;
    EXPECT_EQ(*parsedServer, fromServer);
  }
}

TEST(TestControlMessage, ReadsTheDocumentedExamples)
{
  EXPECT_TRUE(ParseClientMessage(R"({"type":"open","request":1,"model":"dragon"})"));
  const auto blobs =
    ParseClientMessage(R"({"type":"blobs","request":2,"blobs":["levels/12/3","partitions/7"]})");
  ASSERT_TRUE(blobs);
  EXPECT_EQ(std::get<BlobsRequest>(blobs->body),
    (BlobsRequest{ { BlobId::LevelPiece(12, 3), BlobId::Partition(7) } }));
  const auto region =
    ParseClientMessage(R"({"type":"region","request":5,"cell":312,"rings":1,"except":[7,9]})");
  ASSERT_TRUE(region);
  EXPECT_EQ(std::get<RegionRequest>(region->body), (RegionRequest{ 312, 1, { 7, 9 } }));
  EXPECT_TRUE(ParseClientMessage(R"({"type":"cancel","request":5,"later":{}})"));
}

TEST(TestControlMessage, DistinguishesFatalMessagesFromWrongOnes)
{
  for (const char* text : { "", "x", "[]", "7", "\"text\"", "null", "{\"a\":}", "{", "\xFF" })
  {
    EXPECT_EQ(ClientError(text), ErrorCode::InvalidInput) << text;
  }
  const auto padded = [](std::size_t size)
  {
    std::string text = R"({"type":"cancel","request":2})";
    return text + std::string(size - text.size(), ' ');
  };
  EXPECT_TRUE(ParseClientMessage(padded(maximumClientMessageBytes)));
  EXPECT_EQ(ClientError(padded(maximumClientMessageBytes + 1)), ErrorCode::LimitExceeded);

  for (const char* text :
    { "{}", R"({"type":"cancel"})", R"({"request":2})", R"({"type":"cancel","request":0})",
      R"({"type":"cancel","request":-1})", R"({"type":"cancel","request":4294967296})",
      R"({"type":"cancel","request":"2"})", R"({"type":"cancel","request":1.0})",
      R"({"type":"dance","request":2})", R"({"type":5,"request":2})",
      R"({"type":"open","request":2})", R"({"type":"open","request":2,"model":".."})",
      R"({"type":"open","request":2,"model":"a/../b"})", R"({"type":"blobs","request":2})",
      R"({"type":"blobs","request":2,"blobs":7})", R"({"type":"blobs","request":2,"blobs":[7]})",
      R"({"type":"blobs","request":2,"blobs":[["tree/1"]]})",
      R"({"type":"blobs","request":2,"blobs":["levels/31/1"]})",
      R"({"type":"blobs","request":2,"blobs":["levels/3/0"]})",
      R"({"type":"blobs","request":2,"blobs":["tree/2147483648"]})",
      R"({"type":"region","request":2,"rings":1})",
      R"({"type":"region","request":2,"cell":1,"rings":4})",
      R"({"type":"region","request":2,"cell":1,"rings":-1})",
      R"({"type":"region","request":2,"cell":1,"rings":1,"except":[1073741824]})" })
  {
    EXPECT_EQ(ClientError(text), ErrorCode::InvalidArgument) << text;
  }
}

TEST(TestControlMessage, FindsTheRequestOfAWrongMessage)
{
  EXPECT_EQ(FindRequestId(R"({"type":"dance","request":12})"), 12u);
  EXPECT_EQ(FindRequestId(R"({"type":"dance","request":"12"})"), 0u);
  EXPECT_EQ(FindRequestId(R"({"type":"dance"})"), 0u);
  EXPECT_EQ(FindRequestId("nonsense"), 0u);
}

TEST(TestControlMessage, RefusesWrongAnswers)
{
  for (const char* text : { "", "[]", R"({"type":"end","request":1})",
         R"({"type":"progress","request":0,"blobs":1,"bytes":1})",
         R"({"type":"error","request":1,"code":200,"message":"x"})",
         R"({"type":"error","request":1,"code":500,"message":"x","blob":"tree/0"})",
         R"({"type":"opened","request":1,"model":5})", R"({"type":"opened","request":1})",
         R"({"type":"begin","request":1,"blobs":-1,"bytes":0})",
         R"({"type":"begin","request":1,"blobs":1,"bytes":0,"partitions":{}})" })
  {
    EXPECT_FALSE(ParseServerMessage(text)) << text;
  }
  EXPECT_TRUE(ParseServerMessage(R"({"type":"error","request":0,"code":400,"message":"x"})"));
  EXPECT_FALSE(ParseServerMessage("{\"type\":" + std::string(500000, '[')));
}

TEST(TestControlMessage, HostileMessagesAreRefusedOrComeBack)
{
  RandomMessages random(11);
  int whole = 0;
  for (int i = 0; i < 20000; ++i)
  {
    const auto client = ParseClientMessage(random.Mutated(WriteClientMessage(random.FromClient())));
    if (client)
    {
      ++whole;
      EXPECT_EQ(*ParseClientMessage(WriteClientMessage(*client)), *client);
    }
  }
  for (int i = 0; i < 4000; ++i)
  {
    const auto server = ParseServerMessage(random.Mutated(WriteServerMessage(random.FromServer())));
    if (server)
    {
      ++whole;
      EXPECT_EQ(*ParseServerMessage(WriteServerMessage(*server)), *server);
    }
  }
  EXPECT_GT(whole, 500);
}
