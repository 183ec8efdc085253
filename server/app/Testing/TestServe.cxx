// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve as a process: its output, its signals, its exit codes.
#include "Testing/Fixtures/Eventually.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/app/Testing/ServeProcess.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/TlsTestClient.h"

#include <sys/stat.h>

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;

namespace
{

// A server with a file that is larger than the buffers of sockets.
class Ending : public Serve
{
protected:
  const std::string large = std::string(32u << 20, 'x');

  void SetUp() override
  {
    Serve::SetUp();
    this->Build("one.kds");
    std::ofstream(this->folder / "index.html") << "home";
    std::ofstream(this->folder / "large") << this->large;
  }
  std::vector<std::string> Arguments(const std::string& drain) const
  {
    return { this->stores, "--port", "0", "--web", this->folder, "--drain", drain };
  }
  // Requests the file, and waits until the server has begun to send it.
  static void AskForIt(HttpTestClient& client, std::uint16_t port)
  {
    client.Send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
    HttpTestClient other(port);
    EXPECT_TRUE(fixtures::Eventually(
      [&]
      {
        return other.Get("/metrics")->body.find("kdstream_reader_queue_length_count 1\n") !=
               std::string::npos;
      }));
  }
};

}

TEST_F(Serve, ServesAFolderUntilItIsStopped)
{
  this->Build("one.kds");
  std::ofstream(this->stores / "broken.kds") << "nonsense";
  std::ofstream(this->folder / "index.html") << "home";
  const auto log = this->folder / "access.log";
  Process serve({ this->stores, "--port", "0", "--access-log", log, "--web", this->folder });
  const auto port = serve.Port();
  const auto warning = serve.ErrorLine();
  EXPECT_EQ(warning, "kdstream-serve: warning: " + (this->stores / "broken.kds").string() +
                       ": not a KdStream store; this store is left out, the others are served");

  const auto models = HttpTestClient(port).Get("/api/models.json");
  ASSERT_TRUE(models);
  EXPECT_EQ(ParseModelList(models->body)->size(), 1u);
  EXPECT_EQ(HttpTestClient(port).Get("/")->body, "home");

  this->Build("two.kds");
  serve.Signal(SIGHUP);
  EXPECT_TRUE(fixtures::Eventually([&]
    { return ParseModelList(HttpTestClient(port).Get("/api/models.json")->body)->size() == 2; }));

  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.OutLine(), "") << "one line only";
  const auto text = fixtures::ReadWhole(log);
  EXPECT_NE(text.find(" 127.0.0.1 \"GET /api/models.json\" 200 "), std::string::npos) << text;
}

// Names of files that others have put into the folder cannot forge a line, nor control a terminal.
TEST_F(Serve, NamesOfFilesMakeNoLines)
{
  this->Build("one.kds");
  std::ofstream(this->stores / "a\nkdstream-serve: error: b\x1b[31m.kds") << "nonsense";
  Process serve({ this->stores, "--port", "0" });
  const std::string line = serve.ErrorLine(), begin = "kdstream-serve: warning: ";
  EXPECT_EQ(line.substr(0, line.find(": a model's name")),
    begin + (this->stores / "a?kdstream-serve: error: b?[31m.kds").string());
}

TEST_F(Serve, NamesItsSite)
{
  this->Build("one.kds");
  Process serve(
    { this->stores, "--port", "0", "--site-title", "Museum", "--site-text", "Bones & \"stones\"" });
  const auto models = HttpTestClient(serve.Port()).Get("/api/models.json");
  ASSERT_TRUE(models);
  EXPECT_EQ(
    models->body.rfind(
      R"({"site":{"title":"Museum","text":"Bones & \"stones\""},"models":[{"id":"one",)", 0),
    0u)
    << models->body;
  Process wrong({ this->stores, "--port", "0", "--site-title", "two\nlines" });
  EXPECT_NE(wrong.ErrorLine().find("--site-title"), std::string::npos);
  EXPECT_EQ(wrong.Wait(), 2);
}

// More clients connect than there are descriptors. Clients without a slot are disconnected at once,
// and the server itself never runs out: new stores are read, and the administrator is answered.
TEST_F(Serve, RunsOutOfPlacesBeforeDescriptors)
{
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer itself needs descriptors when it looks at an object's type";
#endif
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0", "--threads", "2", "--admin", "127.0.0.1:0" },
    program, rlimit{ 60, 60 });
  const auto port = serve.Port();
  const auto warning = serve.ErrorLine();
  const std::string start =
    "kdstream-serve: warning: --max-connections 1000: this process may open "
    "60 descriptors, which is enough for only ";
  ASSERT_EQ(warning.substr(0, start.size()), start);
  EXPECT_LE(std::stoi(warning.substr(start.size())), 24) << warning;
  const auto admin = serve.AdminPort();
  StreamTestClient connected(port);
  ASSERT_TRUE(connected.Open());
  connected.Ask({ 1, protocol::OpenRequest{ "one" } });
  ASSERT_TRUE(connected.Await(1).opened);
  std::size_t turnedAway = 0;
  {
    std::vector<std::unique_ptr<HttpTestClient>> crowd;
    for (int i = 0; i < 100; ++i)
    {
      crowd.push_back(std::make_unique<HttpTestClient>(port)); // sends nothing
    }
    for (std::size_t i = crowd.size(); i > 60; --i) // the last ones that connected
    {
      turnedAway += crowd[i - 1]->Ends() ? 1 : 0;
    }
    HttpTestClient administrator(admin);
    const auto metrics = administrator.Get("/metrics");
    ASSERT_TRUE(metrics);
    EXPECT_NE(metrics->body.find("kdstream_failures_total{what=\"accept\"} 0\n"), std::string::npos)
      << metrics->body;
    this->Build("two.kds");
    serve.Signal(SIGHUP);
    std::uint32_t request = 1;
    EXPECT_TRUE(fixtures::Eventually( // while the crowd is still connected
      [&]
      {
        connected.Ask({ ++request, protocol::OpenRequest{ "two" } });
        return connected.Await(request).opened;
      }));
    ++request;
    connected.Ask({ request, protocol::AskPartitions({ 0 }) });
    EXPECT_EQ(connected.Await(request).blobs.size(), 1u);
  }
  EXPECT_EQ(turnedAway, 40u);
  EXPECT_TRUE(fixtures::Eventually( // when the crowd has gone
    [&]
    {
      const auto answer = HttpTestClient(port).Get("/api/models/two/model.json");
      return answer && answer->status == 200;
    }));
  connected.Close();
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Serve, DoesNotStartWithTooFewDescriptors)
{
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0", "--threads", "2" }, program, rlimit{ 32, 32 });
  EXPECT_EQ(serve.Wait(), 1);
  const auto line = serve.ErrorLine();
  EXPECT_EQ(line.substr(0, line.find(", but needs at least ")),
    "kdstream-serve: error: this process may open 32 descriptors");
}

// The count works even if no descriptor is left for listing the others.
TEST_F(Serve, CountsItsDescriptorsThoughTheyHaveRunOut)
{
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer itself needs descriptors";
#endif
  this->Build("one.kds");
  const auto needs = [this](rlim_t limit) -> std::optional<int>
  {
    Process serve(
      { this->stores, "--port", "0", "--threads", "2" }, program, rlimit{ limit, limit });
    EXPECT_EQ(serve.Wait(), 1) << limit;
    const std::string before = "but needs at least ";
    const auto line = serve.ErrorLine();
    const auto place = line.find(before);
    return place == line.npos ? std::nullopt
                              : std::optional(std::stoi(line.substr(place + before.size())));
  };
  const auto enough = needs(32);
  ASSERT_TRUE(enough);
  EXPECT_GT(*enough, 32);
  unsigned reported = 0;
  for (rlim_t limit = 5; limit < 12; ++limit) // with fewer the folder cannot be read
  {
    if (const auto few = needs(limit))
    {
      ++reported;
      EXPECT_GE(*few, *enough - 2) << limit << " descriptors: without the store at most";
    }
  }
  EXPECT_GT(reported, 0u);
  // As many descriptors as the message asks for are enough, even for a folder with more stores than
  // descriptors.
  constexpr int models = 90;
  for (int i = 0; i < models; ++i)
  {
    std::filesystem::copy_file(
      this->stores / "one.kds", this->stores / (std::to_string(i) + ".kds"));
  }
  const auto asked = static_cast<rlim_t>(*enough);
  Process serve({ this->stores, "--port", "0", "--threads", "2" }, program, rlimit{ asked, asked });
  const auto port = serve.Port();
  for (int i = 0; i < models; ++i)
  {
    const auto answer =
      HttpTestClient(port).Get("/api/models/" + std::to_string(i) + "/model.json");
    ASSERT_TRUE(answer && answer->status == 200) << i;
  }
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Serve, StreamsHaveTheLimitsOfItsOptions)
{
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0", "--max-message", "8000", "--max-list", "2",
    "--max-requests", "1", "--max-region", "1" });
  const auto port = serve.Port();
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.SendText(R"({"request":1,"type":"open","model":"one"})" + std::string(7900, ' '));
  ASSERT_TRUE(stream.Await(1).opened);
  stream.Ask({ 2, protocol::AskPartitions({ 0, 0, 0 }) });
  const auto listed = stream.Await(2).error;
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->code, 400u);
  stream.SendText(std::string(8001, ' '));
  while (stream.Receive())
  {
    // The messages that say why the stream ends.
  }
  EXPECT_EQ(stream.CloseCode(), 1009u);
  Process small({ this->stores, "--max-message", "4095" });
  EXPECT_EQ(small.Wait(), 2);
  EXPECT_NE(small.AnyErrorLine().find("--max-message"), std::string::npos);
}

TEST_F(Serve, TakesAllTheDescriptorsThatItMayHave)
{
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0" }, program, rlimit{ 48, 4096 });
  EXPECT_NE(serve.Port(), 0);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(), "") << "enough for all clients";
}

// The server writes more warnings than fit into a pipe that nobody reads.
TEST_F(Serve, WaitsForNobodyWhoReadsWhatItSays)
{
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0" });
  const auto port = serve.Port();
  for (int i = 0; i < 500; ++i)
  {
    std::ofstream(this->stores / (std::string(200, 'x') + " " + std::to_string(i) + ".kds"));
  }
  this->Build("two.kds");
  EXPECT_TRUE(fixtures::Eventually(
    [&] { return HttpTestClient(port).Get("/api/models/two/model.json")->status == 200; }));
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Serve, AnOverwrittenStoreIsOpenedAgainByItself)
{
  this->Build("one.kds");
  this->Build("other", 2);
  Process serve({ this->stores, "--port", "0" });
  HttpTestClient client(serve.Port());
  const auto digest = [&client]
  {
    const auto model = client.Get("/api/models/one/model.json");
    return model && model->status == 200 ? ParseModel(model->body)->digest : "";
  };
  const auto before = digest();
  ASSERT_FALSE(before.empty());
  {
    std::ifstream in(this->stores / "other", std::ios::binary);
    std::ofstream out(this->stores / "one.kds", std::ios::binary);
    out << in.rdbuf();
  }
  std::string after;
  EXPECT_TRUE(fixtures::Eventually(
    [&]
    {
      after = digest();
      return !after.empty();
    }));
  EXPECT_NE(after, before);
}

TEST_F(Serve, AnEmptyFolderIsServed)
{
  Process serve({ this->stores, "--port", "0" });
  const auto port = serve.Port();
  EXPECT_EQ(HttpTestClient(port).Get("/api/models")->body, "{\"models\":[]}");
  EXPECT_EQ(serve.ErrorLine(), "kdstream-serve: warning: " + this->stores.string() +
                                 ": this folder has no stores (NAME.kds) yet");
  serve.Signal(SIGINT);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Serve, StoresAppearChangeAndGoByThemselves)
{
  const auto log = this->folder / "access.log";
  Process serve({ this->stores, "--port", "0", "--access-log", log });
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto digest = [&client](const std::string& name) -> std::string
  {
    const auto model = client.Get("/api/models/" + name + "/model.json");
    return model && model->status == 200 ? ParseModel(model->body)->digest : "";
  };
  this->Build("one.kds");
  EXPECT_TRUE(fixtures::Eventually([&] { return !digest("one").empty(); }));
  const auto first = digest("one");
  this->Build("one.kds", 2);
  EXPECT_TRUE(fixtures::Eventually([&] { return digest("one") != first; }));
  {
    const auto bytes = fixtures::ReadWhole(this->stores / "one.kds");
    std::ofstream slow(this->stores / "two.kds", std::ios::binary);
    slow << bytes.substr(0, bytes.size() / 2) << std::flush;
    this->Build("three.kds"); // while two is only half written
    EXPECT_TRUE(fixtures::Eventually([&] { return !digest("three").empty(); }));
    EXPECT_EQ(digest("two"), "");
    slow << bytes.substr(bytes.size() / 2);
  }
  EXPECT_TRUE(fixtures::Eventually([&] { return !digest("two").empty(); }));
  fs::remove(this->stores / "one.kds");
  EXPECT_TRUE(fixtures::Eventually([&] { return digest("one").empty(); }));
  fs::rename(log, this->folder / "old.log");
  serve.Signal(SIGHUP);
  // A line that is logged just as the new file is created may still go to the old file.
  EXPECT_TRUE(fixtures::Eventually(
    [&]
    {
      EXPECT_EQ(client.Get("/api/models.json")->status, 200u);
      return fs::exists(log) &&
             fixtures::ReadWhole(log).find("\"GET /api/models.json\" 200 ") != std::string::npos;
    }));
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(), "kdstream-serve: warning: " + this->stores.string() +
                                 ": this folder has no stores (NAME.kds) yet");
  EXPECT_EQ(serve.ErrorLine(), "") << "nothing else to warn of";
}

TEST_F(Ending, FinishesWhatIsInFlight)
{
  Process serve(this->Arguments("100000"));
  const auto port = serve.Port();
  HttpTestClient client(port);
  AskForIt(client, port);
  serve.Signal(SIGTERM);
  EXPECT_TRUE(
    fixtures::Eventually([&] { return HttpTestClient(port).Get("/readyz")->status != 200; }));
  EXPECT_EQ(HttpTestClient(port).Get("/api/models.json")->status, 503u);
  EXPECT_EQ(client.Receive()->body, this->large);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(), "");
}

TEST_F(Ending, TakesNoLongerThanItMay)
{
  Process serve(this->Arguments("0.2"));
  const auto port = serve.Port();
  HttpTestClient deaf(port);
  AskForIt(deaf, port);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(),
    "kdstream-serve: warning: the server stops before all requests are answered");
}

// The client is like a phone that sleeps: it requests nothing, and does not answer when the stream
// ends.
TEST_F(Ending, WaitsForNobodyWhoSleeps)
{
  Process serve(this->Arguments("6"));
  const auto port = serve.Port();
  StreamTestClient asleep(port);
  ASSERT_TRUE(asleep.Open());
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(), "") << "nothing was under way";
}

TEST_F(Ending, ASecondSignalEndsItAtOnce)
{
  Process serve(this->Arguments("100000"));
  const auto port = serve.Port();
  HttpTestClient deaf(port);
  AskForIt(deaf, port);
  serve.Signal(SIGTERM);
  EXPECT_TRUE(
    fixtures::Eventually([&] { return HttpTestClient(port).Get("/readyz")->status != 200; }));
  serve.Signal(SIGINT);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_EQ(serve.ErrorLine(),
    "kdstream-serve: warning: the server stops before all requests are answered");
}

TEST_F(Serve, MetricsHaveAnAddressOfTheirOwn)
{
  this->Build("one.kds");
  const Process serve({ this->stores, "--port", "0", "--admin", "127.0.0.1:0" });
  const auto port = serve.Port();
  EXPECT_EQ(HttpTestClient(serve.AdminPort()).Get("/metrics")->status, 200u);
  EXPECT_EQ(HttpTestClient(port).Get("/metrics")->status, 404u);
}

TEST_F(Serve, TheCertificateIsReadAgainOnSighup)
{
  this->Build("one.kds");
  const auto certificate = this->folder / "cert.pem", key = this->folder / "key.pem";
  WriteSelfSigned(certificate, key, "first");
  Process serve(
    { this->stores, "--port", "0", "--tls-cert", certificate, "--tls-key", key, "--hsts", "77" });
  const auto port = serve.Port("https");
  TlsTestClient client(port);
  EXPECT_EQ(client.ServerName(), "first");
  client.Send("GET /readyz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(client.Receive("ready\n").find("Security: max-age=77\r\n"), std::string::npos);
  WriteSelfSigned(certificate, key, "second");
  serve.Signal(SIGHUP);
  EXPECT_TRUE(fixtures::Eventually([&] { return TlsTestClient(port).ServerName() == "second"; }));
  std::ofstream(certificate) << "nonsense";
  serve.Signal(SIGHUP);
  EXPECT_EQ(serve.ErrorLine(),
    "kdstream-serve: warning: " + certificate.string() +
      ": contains no certificate in PEM format; the earlier certificate stays in use");
  EXPECT_EQ(TlsTestClient(port).ServerName(), "second");
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Serve, FindsThePageThatIsInstalledWithIt)
{
  const auto program_ = this->folder / "bin/kdstream-serve";
  const auto page = this->folder / "share/kdstream/web";
  fs::create_directories(program_.parent_path());
  fs::create_directories(page);
  fs::copy_file(program, program_);
  fs::create_symlink(program_, this->folder / "link");
  const auto home = [this](const std::vector<std::string>& options)
  {
    std::vector<std::string> arguments{ this->stores, "--port", "0" };
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Process serve(arguments, this->folder / "link");
    return HttpTestClient(serve.Port()).Get("/")->body;
  };
  EXPECT_NE(home({}).find("/api/models.json"), std::string::npos) << "no page: text";
  std::ofstream(page / "index.html") << "installed";
  EXPECT_EQ(home({}), "installed");
  const auto other = this->folder / "other";
  fs::create_directories(other);
  std::ofstream(other / "index.html") << "other";
  EXPECT_EQ(home({ "--web", other }), "other");
  std::ofstream(page / "index.html.gz") << "packed";
  const Process serve({ this->stores, "--port", "0" }, program_);
  HttpTestClient client(serve.Port());
  const auto packed = client.Get("/", "Accept-Encoding: br\r\nAccept-Encoding: gzip\r\n");
  EXPECT_EQ(packed->body, "packed");
  EXPECT_EQ(packed->Field("Content-Encoding"), "gzip");
  EXPECT_EQ(client.Get("/", "Accept-Encoding: br, gzip;q=0\r\n")->body, "installed");
}

// Nobody may ever write to the pipe, so the server must not wait for it.
TEST_F(Serve, NoSecretsComeByAPipe)
{
  const auto pipe = this->folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const auto& arguments :
    { std::vector<std::string>{ "--tokens", pipe }, { "--tls-cert", pipe, "--tls-key", pipe } })
  {
    auto all = std::vector<std::string>{ this->stores, "--port", "0" };
    all.insert(all.end(), arguments.begin(), arguments.end());
    Process serve(all);
    EXPECT_EQ(serve.OutLine(), "");
    const std::string line = serve.ErrorLine();
    EXPECT_EQ(line.substr(0, 23), "kdstream-serve: error: ");
    EXPECT_NE(line.find("is not a file"), std::string::npos) << line;
    EXPECT_EQ(serve.Wait(), 1);
  }
}

TEST_F(Serve, ReportsWhyItCannotServe)
{
  this->Build("one.kds");
  const std::uintmax_t bytes = fs::file_size(this->stores / "one.kds");
  Process first({ this->stores, "--port", "0" });
  const auto port = std::to_string(first.Port());
  const std::pair<std::vector<std::string>, int> wrong[] = {
    { {}, 2 },
    { { this->stores, "--port", "99999" }, 2 },
    { { this->stores, "--token", "x" }, 2 },
    { { this->stores, "--threads", "0" }, 2 },
    { { this->stores, "--tls-cert", "x.pem" }, 2 },
    { { this->stores, "--port", "0", "--tls-cert", "x.pem", "--tls-key", "y.pem" }, 1 },
    { { this->stores, "--admin", "9100" }, 2 },
    { { this->stores, "--admin", "::1:9100" }, 2 },
    { { this->stores, "--admin", "127.0.0.1:70000" }, 2 },
    { { this->stores, "--port", "0", "--admin", "127.0.0.1:" + port }, 1 },
    { { this->stores, "--drain", "-1" }, 2 },
    { { this->stores, "--trusted-proxy", "10.0.0.1", "--trusted-proxy", "10.0.0.1:80" }, 2 },
    { { this->stores, "--proxy-protocol" }, 2 },
    { { this->folder / "missing", "--port", "0" }, 1 },
    { { this->stores, "--port", port }, 1 },
    { { this->stores, "--port", "0", "--host", "no-such-host.invalid" }, 1 },
    { { this->stores, "--port", "0", "--web", this->folder / "missing" }, 1 },
    { { this->stores, "--port", "0", "--web", this->stores }, 1 }, // the folder has no page
    { { this->stores, "--port", "0", "--access-log", this->folder / "missing/log" }, 1 },
    { { this->stores, "--port", "0", "--access-log", this->stores / "one.kds" }, 2 },
  };
  for (const auto& [arguments, code] : wrong)
  {
    Process serve(arguments);
    EXPECT_EQ(serve.OutLine(), ""); // the program has ended
    serve.Signal(SIGTERM);          // in case it has not ended
    EXPECT_EQ(serve.ErrorLine().substr(0, 23), "kdstream-serve: error: ");
    EXPECT_EQ(serve.Wait(), code) << (arguments.empty() ? "" : arguments.back());
  }
  EXPECT_EQ(fs::file_size(this->stores / "one.kds"), bytes) << "no line of a log in a store";
  // The message is ours, not the system's.
  const auto line = [](const std::string& directory)
  {
    Process serve({ directory, "--port", "0" });
    serve.OutLine();
    const std::string error = serve.ErrorLine();
    serve.Signal(SIGTERM);
    EXPECT_EQ(serve.Wait(), 1);
    return error;
  };
  const std::string store = this->stores / "one.kds";
  EXPECT_EQ(line(store), "kdstream-serve: error: " + store +
                           ": is a file, not a folder: give the folder that contains it");
  EXPECT_EQ(line("start"), "kdstream-serve: error: start: there is no such folder (kdstream-serve "
                           "needs the folder of the stores; its only command is token)");
}

// Values without a meaning are refused, and only those.
TEST_F(Serve, RefusesValuesThatMeanNothing)
{
  const std::string seconds = "a number from 0.001 to 1000000";
  const std::string proxy = "an address or a network, such as 10.0.0.1 or 10.0.0.0/8";
  const std::string host =
    "a host, without scheme and port, such as models.example.org, 192.0.2.1 or [2001:db8::1]";
  const std::string origin = "* or an origin in the form that browsers send, such as "
                             "https://example.org or http://localhost:3000";
  const std::pair<std::array<std::string, 2>, std::string> wrong[] = {
    { { "--drain", "nan" }, "a number from 0 to 1000000" },
    { { "--drain", "inf" }, "a number from 0 to 1000000" },
    { { "--drain", "1e7" }, "a number from 0 to 1000000" },
    { { "--request-timeout", "nan" }, seconds },
    { { "--idle-timeout", "0" }, seconds },
    { { "--slowest", "0" }, "a size of at least 1" },
    { { "--slowest", "0K" }, "a size of at least 1" },
    { { "--trusted-proxy", "proxy" }, proxy },
    { { "--trusted-proxy", "10.0.0.0/33" }, proxy },
    { { "--allow-host", "https://example.org" }, host },
    { { "--allow-host", "example.org:8700" }, host },
    { { "--allow-host", "::1" }, host },
    { { "--allow-host", "[1]" }, host },
    { { "--allow-host", "*" }, host },
    { { "--allow-origin", "example.org" }, origin },
    { { "--allow-origin", "https://example.org/" }, origin },
    { { "--allow-origin", "https://Example.org" }, origin },
    { { "--allow-origin", "https://example.org:443" }, origin },
    { { "--allow-origin", "https://example.org:0" }, origin },
    { { "--allow-origin", "https://" }, origin },
    { { "--allow-origin", "null" }, origin },
  };
  for (const auto& [option, what] : wrong)
  {
    Process serve({ this->stores, "--port", "0", option[0], option[1] });
    EXPECT_EQ(serve.OutLine(), "") << option[1];
    serve.Signal(SIGTERM); // in case it has not ended
    EXPECT_EQ(serve.ErrorLine(), "kdstream-serve: error: " + option[0] + ": \"" + option[1] +
                                   "\" is not " + what + " (see --help)");
    EXPECT_EQ(serve.Wait(), 2);
  }
  Process good({ this->stores, "--port", "0", "--drain", "0", "--slowest", "1", "--trusted-proxy",
    "10.0.0.0/8", "--trusted-proxy", "::1", "--allow-host", "Models.example.org", "--allow-host",
    "[::1]", "--allow-host", "my_host.", "--allow-origin", "https://[::1]:8443" });
  EXPECT_NE(good.Port(), 0);
}

// A file that is too large to be served is reported once, and does not count as the server's
// failure.
TEST_F(Serve, SaysWhatOfThePageItCannotServe)
{
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "large.bin") << "large";
  fs::resize_file(this->folder / "large.bin", (std::uintmax_t{ 64 } << 20) + 1);
  this->Build("one.kds");
  Process serve({ this->stores, "--port", "0", "--web", this->folder });
  HttpTestClient client(serve.Port());
  const auto line =
    "kdstream-serve: warning: " + fs::canonical(this->folder / "large.bin").string() +
    ": the file is larger than 64 MiB, too large to serve";
  for (int i = 0; i < 3; ++i)
  {
    const auto answer = client.Get("/large.bin");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 404u);
    EXPECT_EQ(answer->body, "{\"error\":\"the file is larger than 64 MiB, too large to serve\"}\n");
  }
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.ErrorLine(), line);
  EXPECT_EQ(serve.ErrorLine(), "") << "once";
  EXPECT_EQ(serve.Wait(), 0);
}

// A log that cannot grow loses lines, which is reported; requests are still answered.
TEST_F(Serve, AFullLogEndsNothing)
{
  this->Build("one.kds");
  const auto log = this->folder / "access.log";
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{ 4096, before.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  Process serve({ this->stores, "--port", "0", "--access-log", log });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  HttpTestClient client(serve.Port());
  for (int i = 0; i < 200; ++i)
  {
    const auto answer = client.Get("/healthz");
    ASSERT_TRUE(answer) << i;
    EXPECT_EQ(answer->status, 200u);
  }
  const std::string line = serve.ErrorLine();
  EXPECT_EQ(line.rfind("kdstream-serve: warning: " + log.string() + ": ", 0), 0u) << line;
  EXPECT_NE(line.find(" log lines were lost: File too large"), std::string::npos) << line;
  EXPECT_EQ(fs::file_size(log) <= 4096, true);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// A client that connects by IPv4 to an IPv6 socket is logged, and counted, under its IPv4 address.
TEST_F(Serve, LogsAddressesOfIPv4AsThatOnASocketOfIPv6)
{
  const auto log = this->folder / "access.log";
  this->Build("one.kds");
  Process serve({ this->stores, "--host", "::", "--port", "0", "--access-log", log });
  const auto line = serve.OutLine();
  const std::string start = "listening on http://[::]:";
  if (line.empty())
  {
    GTEST_SKIP() << "no IPv6 here: " << serve.ErrorLine();
  }
  ASSERT_EQ(line.substr(0, start.size()), start);
  HttpTestClient client(static_cast<std::uint16_t>(std::stoi(line.substr(start.size()))));
  EXPECT_EQ(client.Get("/healthz")->status, 200u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  EXPECT_NE(fixtures::ReadWhole(log).find("Z 127.0.0.1 \"GET /healthz\" 200 "), std::string::npos)
    << fixtures::ReadWhole(log);
}
