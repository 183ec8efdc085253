// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve --tokens and kdstream-serve token, as processes.
#include "Testing/Fixtures/Eventually.h"
#include "filters/model/Json.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/app/Testing/ServeProcess.h"
#include "server/http/Testing/HttpTestClient.h"

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>
#include <utility>

using namespace kdstream;

namespace
{

// A server whose clients need tokens, and the command that makes tokens.
class Guarded : public Serve
{
protected:
  const fs::path keys = this->folder / "tokens.json";
  const std::string secret = "0123456789abcdef0123456789abcdef";

  void SetUp() override
  {
    Serve::SetUp();
    this->Build("one.kds");
    this->Build("two.kds");
    this->WriteKeys("");
  }
  // more: further members of the file.
  void WriteKeys(const std::string& more) const
  {
    const auto next = this->folder / "next.json";
    std::ofstream(next) << "{\"secret\":\"" << this->secret << "\"" << more << "}";
    fs::permissions(next, fs::perms::owner_read | fs::perms::owner_write);
    fs::rename(next, this->keys);
  }
  struct Made
  {
    std::string id, token;
  };
  Made Make(const std::vector<std::string>& more) const
  {
    std::vector<std::string> arguments{ "token", "--tokens", this->keys, "--sub", "ann" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    Process process(arguments);
    Made made;
    made.token = process.OutLine();
    const auto line = process.AnyErrorLine(); // kdstream-serve: token ID of ann, valid until …
    made.id = line.substr(std::string("kdstream-serve: token ").size(), 32);
    EXPECT_EQ(process.OutLine(), "");
    EXPECT_EQ(process.Wait(), 0) << line;
    return made;
  }
  static unsigned StatusFor(std::uint16_t port, const std::string& token)
  {
    return HttpTestClient(port)
      .Get("/api/models.json", "Authorization: Bearer " + token + "\r\n")
      ->status;
  }
  // The time in seconds until `token` gets this status, but not more than two.
  static double TimeUntil(unsigned status, std::uint16_t port, const std::string& token)
  {
    const auto begin = std::chrono::steady_clock::now();
    double seconds = 0;
    while (seconds < 2 && StatusFor(port, token) != status)
    {
      seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    return seconds;
  }
};

}

TEST_F(Guarded, TakesTheTokensThatItMakes)
{
  Process serve({ this->stores, "--port", "0", "--tokens", this->keys, "--site-title", "Museum" });
  const auto port = serve.Port();
  EXPECT_EQ(HttpTestClient(port).Get("/api/models.json")->status, 401u);
  const auto token = this->Make({ "--models", "one", "--detail", "levels" }).token;
  const auto list =
    HttpTestClient(port).Get("/api/models.json", "Authorization: Bearer " + token + "\r\n");
  ASSERT_EQ(list->status, 200u);
  ASSERT_EQ(ParseModelList(list->body)->size(), 1u);
  EXPECT_EQ(ParseModelList(list->body)->front().id, "one");
  EXPECT_NE(list->body.find(R"("site":{"title":"Museum"})"), std::string::npos) << list->body;
  EXPECT_EQ(StatusFor(port, this->Make({ "--models", "*", "--detail", "regions" }).token), 200u);
  const auto brief =
    this->Make({ "--models", "*", "--detail", "preview", "--expires", "1s" }).token;
  EXPECT_LT(TimeUntil(401, port, brief), 1.5);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.AnyErrorLine(), "") << "it has nothing to warn of";
}

TEST_F(Guarded, NamesWhoGivesTokens)
{
  Process serve({ this->stores, "--port", "0", "--tokens", this->keys, "--contact",
    "Museum <b>, \"ann\"@example.org" });
  const auto refused = HttpTestClient(serve.Port()).Get("/api/models.json");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 401u);
  EXPECT_EQ(refused->body, "{\"error\":\"this server requires a token\","
                           "\"contact\":\"Museum <b>, \\\"ann\\\"@example.org\"}\n");
  Process wrong({ this->stores, "--port", "0", "--contact", "Ann" });
  EXPECT_NE(wrong.ErrorLine().find("--tokens"), std::string::npos) << "there are none to get";
  EXPECT_EQ(wrong.Wait(), 2);
}

TEST_F(Guarded, FollowsItsFileWithinASecond)
{
  Process serve({ this->stores, "--port", "0", "--tokens", this->keys });
  const auto port = serve.Port();
  const auto first = this->Make({ "--models", "*", "--detail", "regions" });
  const auto second = this->Make({ "--models", "*", "--detail", "regions" });
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open("kdstream.v2, " + first.token));
  EXPECT_EQ(StatusFor(port, first.token), 200u);

  const auto begin = std::chrono::steady_clock::now();
  this->WriteKeys(",\"revoked\":[\"" + first.id + "\"]");
  EXPECT_TRUE(stream.Receive()); // why the stream ends
  EXPECT_FALSE(stream.Receive());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  EXPECT_EQ(StatusFor(port, first.token), 401u);
  EXPECT_EQ(StatusFor(port, second.token), 200u);

  // An invalid file of keys changes nothing, and is reported once; so is a missing one.
  std::ofstream(this->keys) << "nonsense";
  EXPECT_EQ(serve.ErrorLine().substr(0, 25), "kdstream-serve: warning: ");
  EXPECT_EQ(StatusFor(port, first.token), 401u);
  EXPECT_EQ(StatusFor(port, second.token), 200u);
  serve.Signal(SIGHUP);
  EXPECT_NE(serve.ErrorLine().find("the earlier keys stay valid"), std::string::npos);
  fs::remove(this->keys);
  EXPECT_NE(serve.ErrorLine().find("the earlier keys stay valid"), std::string::npos);
  EXPECT_EQ(StatusFor(port, second.token), 200u);

  // With another secret, all earlier tokens become invalid; with the earlier secret beside it, they
  // are valid again.
  this->WriteKeys(",\"id\":\"a\"");
  EXPECT_LT(TimeUntil(401, port, second.token), 1);
  const auto third = this->Make({ "--models", "*", "--detail", "regions" });
  this->WriteKeys(",\"earlier\":[{\"id\":\"a\",\"secret\":\"" + this->secret + "\"}]");
  EXPECT_LT(TimeUntil(200, port, second.token), 1);
  EXPECT_EQ(StatusFor(port, third.token), 200u);
}

// If the file cannot be read for lack of descriptors when it changes, the server reads it later.
TEST_F(Guarded, FollowsItsFileThoughDescriptorsHaveRunOut)
{
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer itself needs descriptors when it looks at an object's type";
#endif
  Process serve({ this->stores, "--port", "0", "--tokens", this->keys }, program, rlimit{ 60, 60 });
  const auto port = serve.Port();
  const auto made = this->Make({ "--models", "*", "--detail", "regions" });
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open("kdstream.v2, " + made.token));
  {
    std::vector<std::unique_ptr<HttpTestClient>> crowd;
    for (int i = 0; i < 100; ++i)
    {
      crowd.push_back(std::make_unique<HttpTestClient>(port)); // sends nothing
    }
    EXPECT_TRUE(crowd.back()->Ends()) << "turned away";
    this->WriteKeys(",\"revoked\":[\"" + made.id + "\"]");
    std::this_thread::sleep_for(std::chrono::milliseconds(600)); // the server looks twice
  }
  EXPECT_TRUE(stream.Receive()) << "why";
  EXPECT_FALSE(stream.Receive());
  EXPECT_EQ(stream.CloseCode(), 1008u);
}

// The server may take long to finish requests in flight after it was asked to end.
TEST_F(Guarded, FollowsItsFileWhileItEnds)
{
  Mesh sheet;
  constexpr std::uint32_t side = 400;
  for (std::uint32_t v = 0; v < side * side; ++v)
  {
    const double x = v / side, y = v % side;
    sheet.points.push_back({ x, y, std::sin(x * y) });
  }
  BuildOptions options;
  options.tree.verticesPerPartition = 20'000;
  ASSERT_TRUE(BuildStore(sheet, "sheet.ply", this->stores / "sheet.kds", options));
  Process serve({ this->stores, "--port", "0", "--tokens", this->keys, "--drain", "100000" });
  const auto port = serve.Port();
  const auto made = this->Make({ "--models", "*", "--detail", "regions" });
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open("kdstream.v2, " + made.token));
  stream.Ask({ 1, protocol::OpenRequest{ "sheet" } });
  const auto opened = stream.Await(1).opened;
  ASSERT_TRUE(opened);
  constexpr std::uint32_t times = 12;
  std::vector<std::uint32_t> asked; // more than the buffers of sockets hold
  for (std::uint32_t p = 0; p < times * opened->model.partitions; ++p)
  {
    asked.push_back(p / times);
  }
  stream.Ask({ 2, protocol::AskPartitions(asked) });
  ASSERT_TRUE(stream.Receive()); // the answer has begun
  serve.Signal(SIGTERM);
  EXPECT_TRUE(
    fixtures::Eventually([&] { return HttpTestClient(port).Get("/readyz")->status != 200; }));
  this->WriteKeys(",\"revoked\":[\"" + made.id + "\"]");
  std::this_thread::sleep_for(std::chrono::seconds(1)); // the longest time that revoking may take
  const auto answer = stream.Await(2);
  ASSERT_TRUE(answer.error) << answer.blobs.size() << " of " << asked.size();
  EXPECT_EQ(answer.error->code, 401u);
  EXPECT_FALSE(stream.Receive());
  EXPECT_EQ(serve.Wait(), 0);
}

// Quotas are kept across restarts, and the audit log says who got what.
TEST_F(Guarded, KeepsQuotasAndAccounts)
{
  const auto quotas = this->folder / "quotas.db", audit = this->folder / "audit.log";
  const std::vector<std::string> arguments{ this->stores, "--port", "0", "--tokens", this->keys,
    "--quota-file", quotas, "--quota-bytes", "1", "--audit-log", audit };
  const auto made = this->Make({ "--models", "one", "--detail", "regions" });
  const auto bearer = "Authorization: Bearer " + made.token + "\r\n";
  std::string digest, blob;
  for (const unsigned status : { 200u, 429u })
  {
    Process serve(arguments);
    const auto port = serve.Port();
    const auto list = HttpTestClient(port).Get("/api/models.json", bearer);
    digest = ParseModelList(list->body)->front().digest;
    blob = "/api/models/one/" + digest + "/partitions/0";
    EXPECT_EQ(HttpTestClient(port).Get(blob, bearer)->status, status);
    serve.Signal(SIGTERM);
    EXPECT_EQ(serve.Wait(), 0);
  }
  const auto text = fixtures::ReadWhole(audit);
  const auto line = ParseJson(text);
  ASSERT_TRUE(line) << text;
  const auto member = [&line](const char* name) { return TextOf(*FindMember(*line, name)); };
  EXPECT_EQ(member("sub"), "ann");
  EXPECT_EQ(member("jti"), made.id);
  EXPECT_EQ(member("client"), "127.0.0.1");
  EXPECT_EQ(member("model"), "one");
  EXPECT_EQ(member("digest"), digest);
  EXPECT_EQ(member("original"), (*Store::Open(this->stores / "one.kds"))->Info().inputDigest);
  EXPECT_EQ(member("time").size(), 20u);
  EXPECT_EQ(FindMember(*line, "partition")->GetInt(), 0);
  EXPECT_GT(FindMember(*line, "bytes")->GetInt(), 0);
}

// The share is accepted with and without its percent sign.
TEST_F(Guarded, TakesAShareInPercent)
{
  for (const char* const share : { "5", "5%", "0.5%", "100%" })
  {
    Process serve({ this->stores, "--port", "0", "--tokens", this->keys, "--quota-file",
      this->folder / "quotas.db", "--quota-partitions", share });
    EXPECT_NE(serve.Port(), 0) << share;
    serve.Signal(SIGTERM);
    EXPECT_EQ(serve.Wait(), 0);
  }
}

TEST_F(Guarded, SaysWhoMay)
{
  Process open({ this->stores, "--port", "0" });
  EXPECT_EQ(
    open.AnyErrorLine(), openToAll + std::string("who can reach this server can load every model"));
  fs::permissions(this->keys, fs::perms::others_read, fs::perm_options::add);
  Process readable({ this->stores, "--port", "0", "--tokens", this->keys });
  EXPECT_EQ(
    readable.AnyErrorLine(), "kdstream-serve: warning: " + this->keys.string() +
                               ": every user of this machine can read these keys: run chmod 600");
}

TEST_F(Guarded, RefusesWrongTokensAndFiles)
{
  const std::string file = this->keys;
  const auto broken = this->folder / "broken.json";
  std::ofstream(broken) << "{\"secret\":\"short\"}";
  const std::vector<std::pair<std::vector<std::string>, int>> wrong{
    { { "token" }, 2 },
    { { "token", "--tokens", file, "--sub", "ann", "--models", "*" }, 2 },
    { { "token", "--tokens", file, "--sub", "ann", "--models", "*", "--detail", "all" }, 2 },
    { { "token", "--tokens", file, "--sub", "", "--models", "*", "--detail", "levels" }, 2 },
    { { "token", "--tokens", file, "--sub", "ann", "--models", "a/b", "--detail", "levels" }, 2 },
    { { "token", "--tokens", file, "--sub", "a", "--models", "*", "--detail", "levels", "--expires",
        "7" },
      2 },
    { { "token", "--tokens", file, "--sub", "a", "--models", "*", "--detail", "levels", "--expires",
        "9999999999d" },
      2 },
    { { "token", "--tokens", broken, "--sub", "ann", "--models", "*", "--detail", "levels" }, 1 },
    { { "token", "--tokens", this->folder / "none", "--sub", "a", "--models", "*", "--detail",
        "levels" },
      1 },
    { { this->stores, "--port", "0", "--tokens", broken }, 1 },
    { { this->stores, "--port", "0", "--tokens", this->folder / "none" }, 1 },
    { { this->stores, "--port", "0", "--quota-file", this->folder / "quotas.db" }, 2 },
    { { this->stores, "--port", "0", "--tokens", file, "--quota-bytes", "1M" }, 2 },
    { { this->stores, "--port", "0", "--tokens", file, "--quota-file", file, "--quota-bytes",
        "1M" },
      1 },
    { { this->stores, "--port", "0", "--tokens", file, "--quota-file", this->folder / "q.db",
        "--quota-partitions", "101%" },
      2 },
    { { this->stores, "--port", "0", "--tokens", file, "--quota-file", this->folder / "q.db",
        "--quota-partitions", "5%%" },
      2 },
    { { this->stores, "--port", "0", "--audit-log", this->folder / "missing/log" }, 1 },
  };
  for (const auto& [arguments, code] : wrong)
  {
    Process process(arguments);
    EXPECT_EQ(process.OutLine(), "");
    EXPECT_EQ(process.AnyErrorLine().substr(0, 14), "kdstream-serve") << arguments.back();
    EXPECT_EQ(process.Wait(), code) << arguments.back();
  }
}
