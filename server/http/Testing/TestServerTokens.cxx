// SPDX-License-Identifier: BSD-3-Clause
// A server with tokens, on real sockets: who gets what, by GET and by stream, and for how long.
#include "server/access/Testing/ForgedToken.h"
#include "server/http/Testing/ServerTest.h"

#include "filters/model/ModelJson.h"
#include "filters/protocol/Testing/AskedBlobs.h"

#include <atomic>
#include <chrono>
#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

class Tokens : public ServerTest
{
protected:
  std::atomic<std::int64_t> time{ 1000 };
  std::shared_ptr<TokenGuard> guard =
    std::make_shared<TokenGuard>(forged::Keys(), [this] { return this->time.load(); });
  std::uint16_t port = 0;

  void SetUp() override
  {
    this->catalog.Add("vase", 2, 3, 100);
    this->options.guard = this->guard;
    this->port = this->Start();
  }
  void TearDown() override { this->server.reset(); }

  static std::string Token(const std::string& detail, const std::string& models = R"(["dragon"])")
  {
    return forged::Token(forged::header,
      R"({"sub":"ann","exp":2000,"models":)" + models + R"(,"detail":")" + detail + "\"}");
  }
  static std::string Bearer(const std::string& token)
  {
    return "Authorization: Bearer " + token + "\r\n";
  }
  HttpTestClient::Response Get(const std::string& target, const std::string& fields = "") const
  {
    return HttpTestClient(this->port).Get(target, fields).value_or(HttpTestClient::Response());
  }
  // Whether a stream that offers these subprotocols can be opened.
  bool Streams(const std::string& subprotocols) const
  {
    StreamTestClient client(this->port);
    return client.Open(subprotocols) && client.Subprotocol() == "kdstream.v2";
  }
};

}

TEST_F(Tokens, WithoutAValidOneNothingOfModelsIsReportedByGet)
{
  const std::string other =
    forged::Token(forged::header, forged::claims, std::string(32, 'x')); // signed by somebody else
  const auto expired =
    forged::Token(forged::header, R"({"sub":"ann","exp":999,"models":"*","detail":"regions"})");
  const std::string dragon = "/api/models/dragon/model.json";
  for (const std::string& target : { std::string("/api/models.json"), dragon,
         std::string("/api/models/nothing/model.json"), this->Blob(BlobId::Partition(0)) })
  {
    for (const std::string& fields :
      { std::string(), Bearer(other), Bearer(expired), Bearer("x.y.z"),
        std::string("Authorization: Basic YTpi\r\n"), Bearer(Token("regions") + "A") })
    {
      const auto answer = this->Get(target, fields);
      EXPECT_EQ(answer.status, 401u) << target << " " << fields;
      EXPECT_EQ(answer.Field("WWW-Authenticate"), "Bearer");
      EXPECT_EQ(answer.body.find("dragon"), std::string::npos) << answer.body;
    }
    EXPECT_EQ(this->Get(target + "?token=" + Token("regions")).status, 401u) << "logs keep targets";
  }
  EXPECT_EQ(this->Get("/healthz").status, 200u);
  EXPECT_EQ(this->Get("/").status, 200u) << "the page itself is for everybody";
}

TEST_F(Tokens, AllowWhatTheySayByGet)
{
  const auto levels = Bearer(Token("levels"));
  const auto list = this->Get("/api/models.json", levels);
  ASSERT_EQ(list.status, 200u);
  const auto models = ParseModelList(list.body);
  ASSERT_EQ(models->size(), 1u) << list.body;
  EXPECT_EQ(models->front().id, "dragon");
  EXPECT_EQ(list.Field("Vary"), "Authorization");
  const auto all = this->Get("/api/models.json", Bearer(Token("preview", "\"*\"")));
  EXPECT_EQ(ParseModelList(all.body)->size(), 2u);

  EXPECT_EQ(this->Get("/api/models/dragon/model.json", levels).status, 200u);
  EXPECT_EQ(this->Get("/api/models/vase/model.json", levels).status, 403u);
  EXPECT_EQ(this->Get("/api/models/nothing/model.json", levels).status, 403u);
  const auto piece = this->Get(this->Blob(BlobId::LevelPiece(5, 1)), levels);
  EXPECT_EQ(piece.status, 200u);
  EXPECT_EQ(piece.Field("Cache-Control"), "private, max-age=31536000, immutable");
  EXPECT_EQ(piece.Field("Vary"), "Authorization");
  const auto partition = this->Blob(BlobId::Partition(3));
  EXPECT_EQ(this->Get(partition, levels).status, 403u);
  // The answer does not even reveal that the client already has the blob.
  EXPECT_EQ(this->Get(partition, levels + "If-None-Match: *\r\n").status, 403u);
  EXPECT_EQ(HttpTestClient(this->port).Get(partition, levels, "HEAD")->status, 403u);
  EXPECT_EQ(this->Get(partition, Bearer(Token("regions"))).status, 200u);
}

TEST_F(Tokens, OpenAStreamByFieldOrSubprotocol)
{
  EXPECT_TRUE(this->Streams("kdstream.v2, " + Token("regions")));
  EXPECT_TRUE(this->Streams(Token("regions") + ", kdstream.v2"));
  StreamTestClient native(this->port);
  EXPECT_TRUE(native.Open("kdstream.v2", "Bearer " + Token("regions")));

  StreamTestClient none(this->port), wrong(this->port);
  EXPECT_FALSE(none.Open());
  EXPECT_FALSE(wrong.Open("kdstream.v2, " + Token("regions") + "A"));
  const auto answer =
    this->Get("/api/stream", "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: "
                             "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                             "Sec-WebSocket-Protocol: kdstream.v2\r\n");
  EXPECT_EQ(answer.status, 401u);
  EXPECT_EQ(answer.Field("WWW-Authenticate"), "Bearer");
}

TEST_F(Tokens, AllowWhatTheySayOnAStream)
{
  StreamTestClient client(this->port);
  ASSERT_TRUE(client.Open("kdstream.v2, " + Token("levels")));
  client.Ask({ 1, OpenRequest{ "vase" } });
  EXPECT_EQ(client.Await(1).error->code, 403u);
  client.Ask({ 2, OpenRequest{ "dragon" } });
  ASSERT_TRUE(client.Await(2).opened);
  client.Ask({ 3, AskPieces(0, { 1 }) });
  EXPECT_EQ(client.Await(3).blobs.size(), 1u);
  client.Ask({ 4, RegionRequest{ 128, 1, {} } });
  const auto region = client.Await(4);
  ASSERT_TRUE(region.error);
  EXPECT_EQ(region.error->code, 403u);
  EXPECT_FALSE(region.begin) << "which partitions it has";
}

// A stream must end within a second. One client loads a region, the other one is idle.
TEST_F(Tokens, EndAStreamWhenTheyExpireOrAreRevoked)
{
  using Clock = std::chrono::steady_clock;
  for (const bool expires : { true, false })
  {
    this->time = 1000;
    this->guard->Replace(forged::Keys());
    StreamTestClient idle(this->port), busy(this->port);
    ASSERT_TRUE(idle.Open("kdstream.v2, " + Token("regions")));
    ASSERT_TRUE(busy.Open("kdstream.v2, " + Token("regions")));
    busy.Ask({ 1, OpenRequest{ "dragon" } });
    ASSERT_TRUE(busy.Await(1).opened);
    Clock::time_point ended;
    std::size_t after = 0; // frames received after that
    std::uint32_t request = 2;
    busy.Ask({ request, RegionRequest{ 1, 3, {} } });
    const auto answer = busy.Await(request,
      [&](std::size_t frames)
      {
        if (frames == 3)
        {
          auto keys = forged::Keys();
          keys.revokedSubjects = { "ann" };
          expires ? void(this->time = 2000) : this->guard->Replace(keys);
          ended = Clock::now();
        }
        after += frames > 3 ? 1 : 0;
      });
    ASSERT_TRUE(answer.error);
    EXPECT_EQ(answer.error->code, 401u);
    EXPECT_LT(answer.blobs.size(), this->model->Description().partitions);
    EXPECT_FALSE(busy.Receive());
    EXPECT_EQ(busy.CloseCode(), 1008u);

    const auto last = idle.Receive();
    ASSERT_TRUE(last);
    const auto& error = std::get<ErrorAnswer>(std::get<ServerMessage>(*last).body);
    EXPECT_EQ(error.code, 401u);
    EXPECT_NE(error.message.find(expires ? "expired" : "revoked"), std::string::npos);
    EXPECT_FALSE(idle.Receive());
    EXPECT_EQ(idle.CloseCode(), 1008u);
    EXPECT_LT(Clock::now() - ended, std::chrono::seconds(1));
    EXPECT_EQ(this->Get("/api/models.json", Bearer(Token("regions"))).status, 401u);
  }
}

TEST_F(Tokens, AreInNoLogAndRefusalsAreCounted)
{
  const auto token = Token("levels");
  EXPECT_EQ(this->Get("/api/models.json", Bearer(token)).status, 200u);
  EXPECT_EQ(this->Get(this->Blob(BlobId::Partition(3)), Bearer(token)).status, 403u);
  EXPECT_TRUE(this->Streams("kdstream.v2, " + token));
  HttpTestClient client(this->port);
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"token\"} 1\n", client));
  // On a stream: a model is refused, then a detail, and then the stream itself ends.
  StreamTestClient stream(this->port);
  ASSERT_TRUE(stream.Open("kdstream.v2, " + token));
  stream.Ask({ 1, OpenRequest{ "vase" } });
  EXPECT_EQ(stream.Await(1).error->code, 403u);
  stream.Ask({ 2, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(2).opened);
  stream.Ask({ 3, RegionRequest{ 128, 1, {} } });
  EXPECT_EQ(stream.Await(3).error->code, 403u);
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"token\"} 3\n", client));
  this->time = 2000;
  while (stream.Receive())
  {
  }
  EXPECT_TRUE(MetricsHave("kdstream_refusals_total{reason=\"token\"} 4\n", client));
  this->server.reset();
  EXPECT_GE(this->records.size(), 3u);
  for (const auto& record : this->records)
  {
    EXPECT_EQ(record.target.find(token.substr(0, 10)), std::string::npos);
  }
}
