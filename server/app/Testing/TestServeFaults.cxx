// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve on a failing system: the disk, descriptors, memory, the log's reader, the clock,
// TLS. Only the request that needs the failing part fails; the failure is reported and counted.
// When the system works again, everything works, without a restart.
#include "Testing/Faults/Faults.h"
#include "Testing/Fixtures/Eventually.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/app/Testing/ServeProcess.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/TlsTestClient.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <mutex>
#include <random>
#include <set>
#include <thread>

using namespace kdstream;

namespace
{

const std::string library = KDSTREAM_FAULTS;

// Kills a process that has not ended in time, so that requests to it fail instead of waiting.
class Deadline
{
public:
  explicit Deadline(const Process& process)
    : Thread(
        [this, &process]
        {
          std::unique_lock lock(this->Mutex);
          if (!this->Changed.wait_for(
                lock, std::chrono::seconds(60), [this] { return this->Over; }))
          {
            process.Signal(SIGKILL);
          }
        })
  {
  }
  ~Deadline()
  {
    {
      const std::lock_guard lock(this->Mutex);
      this->Over = true;
    }
    this->Changed.notify_all();
    this->Thread.join();
  }

private:
  std::mutex Mutex;
  std::condition_variable Changed;
  bool Over = false;
  std::thread Thread; // declared after the members that it uses
};

class Faulty : public Serve
{
protected:
  const fs::path shared = this->folder / "faults", keys = this->folder / "tokens.json";
  Faults* faults = nullptr;

  void SetUp() override
  {
    Serve::SetUp();
    std::signal(SIGPIPE, SIG_IGN);
    this->Build("one.kds");
    this->faults = MapFaults(this->shared.c_str(), true);
    ASSERT_NE(this->faults, nullptr);
    ::setenv(faultsVariable, this->shared.c_str(), 1);
    ::setenv("LD_PRELOAD", library.c_str(), 1);
  }
  void TearDown() override
  {
    ::unsetenv("LD_PRELOAD");
    ::unsetenv(faultsVariable);
    ::munmap(this->faults, sizeof(Faults));
  }
  std::vector<std::string> Arguments(const std::vector<std::string>& more = {}) const
  {
    // No blob is kept in memory, so each answer needs the disk.
    std::vector<std::string> arguments{ this->stores, "--port", "0", "--cache-memory", "0" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::string PageWarning(const std::string& reason) const
  {
    return "kdstream-serve: warning: " + (fs::canonical(this->folder) / "page").string() +
           ": the file cannot be read: " + reason;
  }
  // The present value of a metric.
  static std::uint64_t Count(std::uint16_t port, const std::string& name)
  {
    const auto metrics = HttpTestClient(port).Get("/metrics");
    if (!metrics)
    {
      return 0;
    }
    const auto place = ("\n" + metrics->body).find("\n" + name + " ");
    EXPECT_NE(place, std::string::npos) << name;
    return place == std::string::npos ? 0 : std::stoull(metrics->body.substr(place + name.size()));
  }
  static std::string BlobOf(HttpTestClient& client, std::uint32_t partition = 0,
    const std::string& model = "one", const std::string& fields = {})
  {
    const auto reported = client.Get("/api/models/" + model + "/model.json", fields);
    const auto parsed = reported ? ParseModel(reported->body) : Error{};
    EXPECT_TRUE(parsed) << model;
    const auto id = protocol::BlobId::Partition(partition);
    return parsed ? protocol::BlobPath(model, parsed->digest, id) : "";
  }
  // A store of 128 partitions.
  void BuildGrid(const std::string& name) const
  {
    constexpr std::uint32_t side = 160;
    Mesh mesh;
    for (std::uint32_t i = 0; i < side * side; ++i)
    {
      mesh.points.push_back({ double(i % side), double(i / side), double(i * i % 7) });
      if (i % side != 0 && i >= side)
      {
        mesh.triangles.push_back({ i, i - 1, i - side });
      }
    }
    BuildOptions options;
    options.tree.partitions = 128;
    EXPECT_TRUE(BuildStore(std::move(mesh), "grid.ply", this->stores / name, options));
  }
  // Writes keys to a file, and makes a token with them.
  std::string MakeToken() const
  {
    std::ofstream(this->keys) << R"({"secret":"0123456789abcdef0123456789abcdef"})";
    fs::permissions(this->keys, fs::perms::owner_read | fs::perms::owner_write);
    Process process(
      { "token", "--tokens", this->keys, "--sub", "ann", "--models", "*", "--detail", "regions" });
    const auto token = process.OutLine();
    EXPECT_EQ(process.Wait(), 0);
    return token;
  }
  // The status of the answer; 0 if there is none.
  static unsigned Ask(std::uint16_t port, const std::string& target)
  {
    const auto answer = HttpTestClient(port).Get(target);
    return answer ? answer->status : 0;
  }
  static bool AwaitModel(std::uint16_t port, const std::string& model)
  {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!Has(port, model) && std::chrono::steady_clock::now() < until)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return Has(port, model);
  }
  static bool Has(std::uint16_t port, const std::string& model)
  {
    const auto answer = HttpTestClient(port).Get("/api/models/" + model + "/model.json");
    return answer && answer->status == 200;
  }
};

}

TEST_F(Faulty, ADiskThatCannotBeRead)
{
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "page") << "page";
  this->BuildGrid("grid.kds");
  Process serve(this->Arguments({ "--web", this->folder }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, protocol::OpenRequest{ "grid" } });
  ASSERT_TRUE(stream.Await(1).opened);
  const auto warning = [this](std::uint32_t partition)
  {
    return "kdstream-serve: warning: " + (this->stores / "grid.kds").string() + ": partitions/" +
           std::to_string(partition) + ": cannot be read or written: Input/output error";
  };

  // SQLite keeps pages in memory, so each request asks for a different partition.
  this->faults->reading = EIO;
  for (std::uint32_t partition = 0; partition < 3; ++partition)
  {
    const auto refused = client.Get(BlobOf(client, partition, "grid"));
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 503u) << refused->body;
    EXPECT_EQ(refused->Field("Retry-After"), "1");
  }
  const auto page = client.Get("/page");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 503u) << page->body;
  stream.Ask({ 2, protocol::AskPartitions({ 3, 4 }) });
  const auto part = stream.Await(2);
  ASSERT_EQ(part.blobErrors.size(), 2u);
  EXPECT_EQ(part.blobErrors[0].code, 503u);
  EXPECT_TRUE(part.end) << "the request goes on to its end";
  EXPECT_EQ(client.Get("/api/models.json")->status, 200u) << "what needs no disk";
  EXPECT_EQ(client.Get("/readyz")->status, 200u);
  EXPECT_EQ(Count(port, "kdstream_failed_blobs_total"), 5u);
  EXPECT_EQ(Count(port, "kdstream_requests_total{status=\"503\"}"), 4u);
  EXPECT_EQ(serve.ErrorLine(), warning(0));
  EXPECT_EQ(serve.ErrorLine(), this->PageWarning("Input/output error"));
  this->Build("two.kds");
  serve.Signal(SIGHUP); // otherwise it would be taken for an unfinished copy
  EXPECT_EQ(serve.ErrorLine(), "kdstream-serve: warning: " + (this->stores / "two.kds").string() +
                                 ": cannot be read or written: Input/output error; this store is "
                                 "left out, the others are served")
    << "the other is said once, however often it was asked for";
  EXPECT_FALSE(Has(port, "two"));

  this->faults->Clear();
  const auto store = Store::Open(this->stores / "grid.kds");
  for (std::uint32_t partition = 0; partition < 6; ++partition)
  {
    const auto blob = client.Get(BlobOf(client, partition, "grid"))->body;
    const auto node = NodeOfPartition(partition, (*store)->Info().depths);
    const auto whole =
      (*store)->Read(BlobOfPiece({ Resolution::Original(), node }, (*store)->Info().depths));
    ASSERT_TRUE(whole);
    EXPECT_EQ(blob, std::string(whole->begin(), whole->end()));
  }
  EXPECT_EQ(client.Get("/page")->body, "page");
  stream.Ask({ 3, protocol::AskPartitions({ 3, 4 }) });
  EXPECT_EQ(stream.Await(3).blobs.size(), 2u);
  EXPECT_TRUE(fixtures::Eventually([&] { return Has(port, "two"); }));
  this->faults->reading = EIO;
  EXPECT_EQ(client.Get(BlobOf(client, 100, "grid"))->status, 503u);
  EXPECT_EQ(serve.ErrorLine(), warning(100)) << "said again, after it had been well";
}

// The disk of one store hangs. Everything else is served, the folder is followed, and signals are
// obeyed.
TEST_F(Faulty, ADiskThatHangsOnOneStore)
{
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "page") << "page";
  this->Build("hangs.kds");
  Process serve(this->Arguments({ "--web", this->folder, "--readers", "2", "--drain", "1" }));
  const Deadline deadline(serve);
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client, 0, "hangs"), other = BlobOf(client);
  this->faults->hanging = 1;
  std::vector<std::unique_ptr<HttpTestClient>> askers;
  for (int i = 0; i < 100; ++i)
  {
    askers.push_back(std::make_unique<HttpTestClient>(port));
    const std::string path = i % 2 == 0 ? blob : "/api/models/hangs/notes.json";
    askers.back()->Send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_EQ(Ask(port, other), 200u);
  EXPECT_EQ(Ask(port, "/page"), 200u);
  EXPECT_EQ(Ask(port, "/readyz"), 200u);
  this->Build("two.kds");
  serve.Signal(SIGHUP);
  EXPECT_TRUE(AwaitModel(port, "two")) << "another store is seen";
  EXPECT_EQ(Ask(port, "/readyz"), 200u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// The disk of the whole folder hangs. Stores that have been opened are served as far as they are in
// memory.
TEST_F(Faulty, AFolderThatHangs)
{
  const auto hanging = this->folder / "hangs";
  fs::create_directory(hanging);
  fs::rename(this->stores / "one.kds", hanging / "one.kds");
  Process serve({ hanging, "--port", "0", "--drain", "1" });
  const Deadline deadline(serve);
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client);
  EXPECT_EQ(Ask(port, blob), 200u);
  this->faults->hanging = 1;
  serve.Signal(SIGHUP);
  EXPECT_EQ(Ask(port, "/readyz"), 200u);
  EXPECT_EQ(Ask(port, "/api/models/one/model.json"), 200u);
  EXPECT_EQ(Ask(port, blob), 200u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Faulty, AFolderThatHangsAtTheStart)
{
  const auto hanging = this->folder / "hangs";
  fs::create_directory(hanging);
  this->faults->hanging = 1;
  Process serve({ hanging, "--port", "0" });
  const Deadline deadline(serve);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (this->faults->struck == 0 && std::chrono::steady_clock::now() < until)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_GT(this->faults->struck, 0u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// Files of the server itself hang: keys, certificate, logs, quotas, pages. The test takes one at a
// time, because the first one that hangs would hide the others.
TEST_F(Faulty, FilesOfItsOwnThatHang)
{
  const auto hanging = this->folder / "hangs";
  fs::create_directory(hanging);
  this->MakeToken();
  fs::copy(this->keys, hanging / "tokens.json");
  WriteSelfSigned(hanging / "cert.pem", hanging / "key.pem");
  std::ofstream(hanging / "index.html") << "home";
  const std::vector<std::vector<std::string>> kinds{
    { "--tokens", hanging / "tokens.json" },
    { "--tls-cert", hanging / "cert.pem", "--tls-key", hanging / "key.pem" },
    { "--access-log", hanging / "access.log" },
    { "--tokens", this->keys, "--audit-log", hanging / "audit.log" },
    { "--tokens", this->keys, "--quota-file", hanging / "quotas.db", "--quota-bytes", "1G" },
    { "--web", hanging },
  };
  for (auto arguments : kinds)
  {
    arguments.insert(arguments.end(), { "--drain", "1", "--admin", "127.0.0.1:0" });
    {
      Process serve(this->Arguments(arguments));
      const Deadline deadline(serve);
      const auto admin = serve.AdminPort();
      EXPECT_FALSE(serve.OutLine().empty());
      this->faults->hanging = 1;
      serve.Signal(SIGHUP);
      EXPECT_EQ(Ask(admin, "/readyz"), 200u) << arguments[0];
      serve.Signal(SIGTERM);
      EXPECT_EQ(serve.Wait(), 0) << arguments[0];
    }
    this->faults->struck = 0;
    Process serve(this->Arguments(arguments));
    const Deadline deadline(serve);
    EXPECT_TRUE(fixtures::Eventually([this] { return this->faults->struck > 0; })) << arguments[0];
    serve.Signal(SIGTERM);
    EXPECT_EQ(serve.Wait(), 0) << arguments[0] << ": at the start";
    this->faults->Clear();
  }
}

TEST_F(Faulty, NoDescriptors)
{
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "page") << "page";
  Process serve(this->Arguments({ "--web", this->folder }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client);
  this->faults->opening = EMFILE;
  EXPECT_EQ(client.Get("/page")->status, 503u);
  EXPECT_EQ(client.Get(blob)->status, 200u) << "a store is open already";
  this->Build("two.kds");
  // The folder is also read at intervals, so either of the two warnings may come first.
  const std::set<std::string> reported{ serve.ErrorLine(), serve.ErrorLine() };
  EXPECT_EQ(
    reported, (std::set<std::string>{ this->PageWarning("Too many open files"),
                "kdstream-serve: warning: " + this->stores.string() +
                  ": cannot be read: Too many open files; the earlier models are still served" }));
  this->faults->accepting = EMFILE;
  {
    HttpTestClient waits(port);
    EXPECT_TRUE(fixtures::Eventually(
      [&]
      {
        return client.Get("/metrics")->body.find("kdstream_failures_total{what=\"accept\"} 0\n") ==
               std::string::npos;
      }));
  }
  EXPECT_EQ(serve.ErrorLine(),
    "kdstream-serve: error: a connection cannot be accepted: Too many open files");
  EXPECT_EQ(client.Get(blob)->status, 200u) << "who is in stays in";
  this->faults->Clear();
  EXPECT_EQ(HttpTestClient(port).Get("/page")->body, "page");
  EXPECT_TRUE(fixtures::Eventually([&] { return Has(port, "two"); }));
}

TEST_F(Faulty, NoMemoryForAConnection)
{
  Process serve(this->Arguments());
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto list = client.Get("/api/models.json")->body;
  this->faults->leastBytes = 2000;
  this->faults->allocation = ENOMEM;
  // A new connection needs more memory than there is: it is ended, and the next one is accepted.
  EXPECT_FALSE(HttpTestClient(port).Get("/api/models.json"));
  EXPECT_EQ(client.Get("/api/models.json")->body, list) << "who is in stays in";
  this->faults->Clear();
  EXPECT_EQ(HttpTestClient(port).Get("/api/models.json")->body, list);
  EXPECT_GE(Count(port, "kdstream_failures_total{what=\"connection\"}"), 1u);
  // The folder of stores is also read at intervals, and may have lacked memory, too.
  const auto ofFolder = this->stores.string() + ": cannot be read: Cannot allocate memory";
  auto line = serve.ErrorLine();
  while (line.find(ofFolder) != std::string::npos)
  {
    line = serve.ErrorLine();
  }
  EXPECT_EQ(line, "kdstream-serve: error: a connection was closed after an error: out of memory");
}

// Every n-th allocation fails, whatever it is for, while clients send requests of all kinds and
// stores are added. Each client gets an answer or loses its connection. The server survives, and
// works afterwards.
TEST_F(Faulty, MemoryThatFailsNowAndThen)
{
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "page") << "page";
  const auto log = this->folder / "access.log";
  Process serve(this->Arguments({ "--web", this->folder, "--access-log", log }));
  const auto port = serve.Port();
  HttpTestClient before(port);
  const auto blob = BlobOf(before);
  const auto whole = before.Get(blob)->body;
  for (const std::uint64_t every : { 997u, 331u, 101u, 53u, 29u, 17u, 11u, 7u })
  {
    this->faults->allocation.FailEvery(every, ENOMEM);
    for (int round = 0; round < 20; ++round)
    {
      HttpTestClient client(port);
      for (const auto& target : { blob, std::string("/page"), std::string("/api/models.json"),
             std::string("/api/models/one/model.json"), std::string("/metrics") })
      {
        const auto answer = client.Get(target);
        if (!answer)
        {
          break;
        }
        EXPECT_TRUE(answer->status == 200 || answer->status >= 500) << answer->status << target;
        EXPECT_TRUE(target != blob || answer->status != 200 || answer->body == whole);
      }
      StreamTestClient stream(port);
      if (stream.Open())
      {
        stream.Ask({ 1, protocol::OpenRequest{ "one" } });
        stream.Ask({ 2, protocol::RegionRequest{ 1, 1, {} } });
        (void)stream.Await(1); // an answer, or the end of the stream
        (void)stream.Await(2);
      }
    }
    this->Build("new" + std::to_string(every) + ".kds");
    serve.Signal(SIGHUP);
  }
  EXPECT_GT(this->faults->struck, 100u);
  this->faults->Clear();
  serve.Signal(SIGHUP);
  HttpTestClient client(port);
  EXPECT_EQ(client.Get(blob)->body, whole);
  EXPECT_EQ(client.Get("/page")->body, "page");
  EXPECT_TRUE(fixtures::Eventually([&] { return Has(port, "new7"); }));
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, protocol::OpenRequest{ "one" } });
  ASSERT_TRUE(stream.Await(1).opened);
  stream.Ask({ 2, protocol::AskPartitions({ 0 }) });
  EXPECT_EQ(stream.Await(2).blobs.size(), 1u);
  // No slot stays taken: there are three clients, and the one that reads the metric.
  EXPECT_TRUE(fixtures::Eventually([&] { return Count(port, "kdstream_connections") <= 4; }));
  stream.Close();
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// Each system call of a session fails in its turn: either this call only, or the thirty calls after
// it, too (while nothing works at all, every client waits). The session gets answers or loses its
// connection, no slot stays taken, and the next session is served. Every test run tries some of the
// calls, chosen by a seed; KDSTREAM_ALL_FAULTS=1 tries all.
TEST_F(Faulty, EachStepOfASession)
{
  constexpr unsigned deadline = 600; // seconds: a client that waits forever ends the test
  ::alarm(deadline);
  std::ofstream(this->folder / "index.html") << "home";
  std::ofstream(this->folder / "page") << "page";
  this->BuildGrid("grid.kds");
  const auto fields = "Authorization: Bearer " + this->MakeToken() + "\r\n";
  Process serve(this->Arguments({ "--web", this->folder, "--access-log",
    this->folder / "access.log", "--tokens", this->keys, "--quota-file", this->folder / "quotas.db",
    "--quota-bytes", "1G", "--admin", "127.0.0.1:0" }));
  const auto admin = serve.AdminPort();
  const auto port = serve.Port();
  const auto token = fields.substr(fields.find("ey"), fields.size() - fields.find("ey") - 2);
  const auto digest = (*Store::Open(this->stores / "grid.kds"))->Info().digest;
  std::uint32_t partition = 0;
  const auto session = [&]
  {
    partition = (partition + 1) % 128;
    const auto blob = protocol::BlobPath("grid", digest, protocol::BlobId::Partition(partition));
    int served = 0;
    {
      HttpTestClient client(port);
      for (const auto& target : { std::string("/page"), std::string("/api/models.json"), blob })
      {
        const auto answer = client.Get(target, fields);
        EXPECT_TRUE(!answer || answer->status == 200 || answer->status >= 500) << answer->status;
        served += answer && answer->status == 200 ? 1 : 0;
        if (!answer)
        {
          break;
        }
      }
    }
    StreamTestClient stream(port);
    if (!stream.Open(std::string(protocol::streamSubprotocol) + ", " + token))
    {
      return served;
    }
    stream.Ask({ 1, protocol::OpenRequest{ "grid" } });
    served += stream.Await(1).opened ? 1 : 0;
    stream.Ask({ 2, protocol::AskPartitions({ partition }) });
    served += stream.Await(2).blobs.size() == 1 ? 1 : 0;
    stream.Ask({ 3, protocol::RegionRequest{ partition, 1, {} } });
    served += stream.Await(3).end ? 1 : 0;
    stream.Close();
    return served;
  };
  // If a client connects while the server closes others for lack of a descriptor, it is
  // disconnected with them, and may ask again. Otherwise the first request is answered.
  const auto isAnswered = [port](bool mayAskAgain)
  {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    bool answered = HttpTestClient(port).Get("/healthz").has_value();
    while (mayAskAgain && !answered && std::chrono::steady_clock::now() < end)
    {
      answered = HttpTestClient(port).Get("/healthz").has_value();
    }
    return answered;
  };
  constexpr int whole = 6;
  ASSERT_EQ(session(), whole);
  const bool all = std::getenv("KDSTREAM_ALL_FAULTS") != nullptr;
  std::minstd_rand random(13);
  const std::pair<Fault Faults::*, int> kinds[] = { { &Faults::allocation, ENOMEM },
    { &Faults::reading, EIO }, { &Faults::writing, ENOSPC }, { &Faults::opening, EMFILE },
    { &Faults::looking, EIO }, { &Faults::accepting, EMFILE }, { &Faults::mapping, ENOMEM } };
  for (const auto& [kind, reason] : kinds)
  {
    (this->faults->*kind) = 0;
    EXPECT_EQ(session(), whole);
    const std::uint64_t calls = (this->faults->*kind).calls;
    constexpr std::uint64_t sample = 12;
    const auto tries = all ? calls : std::min(calls, sample);
    std::uint64_t lost = 0;
    for (std::uint64_t i = 0; i < 2 * tries; ++i)
    {
      const auto call = all ? i / 2 + 1 : 1 + random() % calls;
      if (kind == &Faults::accepting && i % 2 == 1)
      {
        continue; // no client would get in
      }
      (this->faults->*kind).Fail(reason, call, i % 2 == 0 ? call : call + 30);
      lost += session() < whole ? 1 : 0;
      this->faults->Clear();
      ASSERT_TRUE(isAnswered(kind == &Faults::accepting)) << "call " << call << " of " << calls;
    }
    std::cout << "errno " << reason << ": " << calls << " calls, " << 2 * tries << " sessions, "
              << lost << " that lost something\n";
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    for (int served = 0; served != whole && std::chrono::steady_clock::now() < end;)
    {
      served = session(); // a failed blob is not retried at once
      EXPECT_TRUE(served == whole || std::chrono::steady_clock::now() < end);
    }
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (Count(admin, "kdstream_connections") + Count(admin, "kdstream_streams") > 0 &&
         std::chrono::steady_clock::now() < end)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(Count(admin, "kdstream_connections"), 0u) << "no place stays taken";
  EXPECT_EQ(Count(admin, "kdstream_streams"), 0u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  ::alarm(0);
}

TEST_F(Faulty, AFullDisk)
{
  const auto log = this->folder / "access.log";
  const auto fields = "Authorization: Bearer " + this->MakeToken() + "\r\n";
  Process serve(this->Arguments({ "--access-log", log, "--tokens", this->keys, "--quota-file",
    this->folder / "quotas.db", "--quota-bytes", "1G" }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client, 0, "one", fields);
  EXPECT_EQ(client.Get(blob, fields)->status, 200u);
  EXPECT_TRUE(fixtures::Eventually(
    [&] { return fixtures::ReadWhole(log).find("/partitions/0") != std::string::npos; }));
  this->faults->writing = ENOSPC;
  for (int i = 0; i < 2; ++i)
  {
    EXPECT_EQ(client.Get(blob, fields)->status, 503u) << "what cannot be entered is not given";
  }
  EXPECT_EQ(client.Get("/api/models.json", fields)->status, 200u) << "though it cannot be logged";
  EXPECT_TRUE(
    fixtures::Eventually([&] { return Count(port, "kdstream_lost_log_lines_total") >= 3; }));
  EXPECT_EQ(Count(port, "kdstream_failures_total{what=\"quota\"}"), 2u);
  EXPECT_EQ(serve.ErrorLine(), "kdstream-serve: error: " + (this->folder / "quotas.db").string() +
                                 ": the quotas cannot be recorded: database or disk is full");
  this->faults->Clear();
  EXPECT_EQ(client.Get(blob, fields)->status, 200u);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
  const std::string ofLog = serve.AnyErrorLine();
  EXPECT_EQ(ofLog.rfind("kdstream-serve: warning: " + log.string() + ": ", 0), 0u) << ofLog;
  EXPECT_NE(ofLog.find(" log lines were lost: No space left on device"), std::string::npos)
    << ofLog;
  EXPECT_EQ(serve.AnyErrorLine(), "") << "each is said once";
  const auto text = fixtures::ReadWhole(log);
  EXPECT_NE(text.find(" lines were lost\n"), std::string::npos) << text;
  EXPECT_EQ(text.find(" 503 "), std::string::npos) << text;
}

TEST_F(Faulty, QuotasWhoseFolderGoesAndComes)
{
  const auto place = this->folder / "quotas", away = this->folder / "away";
  fs::create_directory(place);
  this->BuildGrid("grid.kds");
  const auto fields = "Authorization: Bearer " + this->MakeToken() + "\r\n";
  Process serve(this->Arguments({ "--tokens", this->keys, "--quota-file", place / "quotas.db",
    "--quota-partitions", "2%" })); // 2 of 128
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto status = [&](std::uint32_t partition)
  { return client.Get(BlobOf(client, partition, "grid", fields), fields)->status; };
  EXPECT_EQ(status(0), 200u);
  fs::rename(place, away);
  for (std::uint32_t i = 0; i < 3; ++i)
  {
    EXPECT_EQ(status(i), 503u) << "of the original nothing";
  }
  EXPECT_EQ(client.Get("/api/models.json", fields)->status, 200u) << "but all else";
  fs::rename(away, place);
  EXPECT_EQ(status(1), 200u);
  EXPECT_EQ(status(0), 200u);
  EXPECT_EQ(status(2), 403u) << "what was had before counts";
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Faulty, QuotasWhileMemoryFailsNowAndThen)
{
  this->BuildGrid("grid.kds");
  const auto fields = "Authorization: Bearer " + this->MakeToken() + "\r\n";
  Process serve(this->Arguments({ "--tokens", this->keys, "--quota-file",
    this->folder / "quotas.db", "--quota-partitions", "50%" })); // 64 of 128
  const auto port = serve.Port();
  std::vector<std::string> blobs;
  {
    HttpTestClient client(port);
    const auto first = BlobOf(client, 0, "grid", fields);
    for (std::uint32_t partition = 0; partition < 128; ++partition)
    {
      blobs.push_back(first.substr(0, first.size() - 1) + std::to_string(partition));
    }
  }
  std::set<std::size_t> had;
  std::size_t asked = 0;
  for (const std::uint64_t every : { 331u, 211u, 101u, 53u, 47u, 43u, 41u, 37u, 31u, 29u })
  {
    this->faults->allocation.FailEvery(every, ENOMEM);
    for (int i = 0; i < 6; ++i, ++asked)
    {
      HttpTestClient client(port);
      const auto answer = client.Get(blobs[asked], fields);
      if (answer && answer->status == 200)
      {
        had.insert(asked);
      }
    }
    this->faults->allocation = 0;
  }
  this->faults->Clear();
  // A partition that was recorded but did not arrive may be requested again.
  HttpTestClient client(port);
  std::set<std::size_t> all;
  for (std::size_t partition = 0; partition < blobs.size(); ++partition)
  {
    const auto answer = client.Get(blobs[partition], fields);
    ASSERT_TRUE(answer);
    EXPECT_TRUE(answer->status == 200 || answer->status == 403) << answer->status;
    if (answer->status == 200)
    {
      all.insert(partition);
    }
  }
  EXPECT_EQ(all.size(), 64u);
  EXPECT_TRUE(std::includes(all.begin(), all.end(), had.begin(), had.end()));
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// Nobody reads the server's output: its stderr is full, and so is the pipe for its log.
TEST_F(Faulty, PipesThatNobodyReads)
{
  const auto log = this->folder / "access.log";
  ASSERT_EQ(::mkfifo(log.c_str(), 0600), 0);
  const int reader = ::open(log.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  this->BuildGrid("grid.kds");
  Process serve(this->Arguments({ "--access-log", log, "--audit-log", "-" }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client);
  // Each request adds about 100 bytes to either pipe, which holds 65536.
  for (int i = 0; i < 3000; ++i)
  {
    ASSERT_EQ(client.Get(blob)->status, 200u);
  }
  for (std::uint32_t partition = 0; partition < 10; ++partition)
  {
    const auto other = BlobOf(client, 10 * partition, "grid");
    this->faults->reading = EIO; // which causes warnings
    EXPECT_EQ(client.Get(other)->status, 503u);
    this->faults->Clear();
    EXPECT_EQ(client.Get(other)->status, 200u);
  }
  this->Build("broken.kds");
  std::ofstream(this->stores / "broken.kds") << "nonsense";
  serve.Signal(SIGHUP); // causes a warning, too
  this->Build("two.kds");
  EXPECT_TRUE(fixtures::Eventually([&] { return Has(port, "two"); }));
  ::close(reader);
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

TEST_F(Faulty, AClockThatJumps)
{
  constexpr std::int64_t years = std::int64_t{ 10 } * 365 * 24 * 3600;
  const auto log = this->folder / "access.log";
  Process serve(this->Arguments({ "--access-log", log }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  const auto blob = BlobOf(client);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, protocol::OpenRequest{ "one" } });
  ASSERT_TRUE(stream.Await(1).opened);
  std::uint32_t request = 1;
  for (const auto ahead : { years, -years, std::int64_t{ 0 } })
  {
    this->faults->ahead = ahead;
    EXPECT_EQ(client.Get(blob)->status, 200u) << ahead;
    stream.Ask({ ++request, protocol::AskPartitions({ 0 }) });
    EXPECT_EQ(stream.Await(request).blobs.size(), 1u) << ahead;
    const auto name = "new" + std::to_string(request);
    this->Build(name + ".kds");
    EXPECT_TRUE(fixtures::Eventually([&] { return Has(port, name); }));
    std::ofstream(this->stores / ("broken" + name + ".kds")) << "nonsense";
    serve.Signal(SIGHUP);
    // The warning about the previous file may come twice: when the file is noticed, and when the
    // folder is read again.
    EXPECT_TRUE(fixtures::Eventually(
      [&]
      {
        return serve.ErrorLine().find("broken" + name + ".kds: not a KdStream store") !=
               std::string::npos;
      }));
    fs::remove(this->stores / ("broken" + name + ".kds"));
  }
  stream.Close();
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}

// Whether a token is valid depends on the clock: an expired token ends its sessions, and is valid
// again when the clock is corrected.
TEST_F(Faulty, ATokenWhileTheClockJumps)
{
  const auto token = this->MakeToken();
  const auto fields = "Authorization: Bearer " + token + "\r\n";
  Process serve(this->Arguments({ "--tokens", this->keys }));
  const auto port = serve.Port();
  HttpTestClient client(port);
  for (int round = 0; round < 2; ++round)
  {
    EXPECT_EQ(client.Get("/api/models.json", fields)->status, 200u);
    StreamTestClient stream(port);
    ASSERT_TRUE(stream.Open(std::string(protocol::streamSubprotocol) + ", " + token));
    this->faults->ahead = std::int64_t{ 10 } * 365 * 24 * 3600;
    EXPECT_EQ(client.Get("/api/models.json", fields)->status, 401u);
    while (stream.Receive())
    {
      // The messages that say why the stream ends.
    }
    EXPECT_EQ(stream.CloseCode(), 1008u);
    this->faults->Clear();
  }
}

// A damaged store is reported even if its file's time is far ahead of the clock, because the clock
// was set back.
TEST_F(Faulty, AClockThatWasSetBackHidesNothing)
{
  Process serve(this->Arguments());
  const auto port = serve.Port();
  EXPECT_TRUE(Has(port, "one"));
  this->faults->ahead = -std::int64_t{ 365 } * 24 * 3600;
  std::ofstream(this->stores / "broken.kds") << "nonsense";
  EXPECT_NE(serve.ErrorLine().find("broken.kds: not a KdStream store"), std::string::npos);
}

TEST_F(Faulty, NoTlsForAConnection)
{
  const auto certificate = this->folder / "cert.pem", key = this->folder / "key.pem";
  WriteSelfSigned(certificate, key);
  Process serve(
    this->Arguments({ "--tls-cert", certificate, "--tls-key", key, "--admin", "127.0.0.1:0" }));
  const auto admin = serve.AdminPort();
  const auto port = serve.Port("https");
  const std::string ask = "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n";
  TlsTestClient connected(port);
  connected.Send(ask);
  EXPECT_EQ(connected.Receive("ok\n").substr(0, 15), "HTTP/1.1 200 OK");
  this->faults->tls = ENOMEM;
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_FALSE(TlsTestClient(port).IsConnected());
  }
  connected.Send(ask);
  EXPECT_EQ(connected.Receive("ok\n").substr(0, 15), "HTTP/1.1 200 OK") << "who is in stays in";
  EXPECT_EQ(Count(admin, "kdstream_failures_total{what=\"connection\"}"), 3u);
  EXPECT_EQ(serve.ErrorLine(),
    "kdstream-serve: error: a connection was closed after an error: out of memory");
  this->faults->Clear();
  TlsTestClient after(port);
  after.Send(ask);
  EXPECT_EQ(after.Receive("ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Faulty, MemoryThatFailsNowAndThenUnderTls)
{
  const auto certificate = this->folder / "cert.pem", key = this->folder / "key.pem";
  WriteSelfSigned(certificate, key);
  const auto token = this->MakeToken();
  Process serve(this->Arguments({ "--tls-cert", certificate, "--tls-key", key, "--tokens",
    this->keys, "--quota-file", this->folder / "quotas.db", "--quota-bytes", "1G", "--audit-log",
    this->folder / "audit.log" }));
  const auto port = serve.Port("https");
  const auto digest = (*Store::Open(this->stores / "one.kds"))->Info().digest;
  const auto ask = "GET " + protocol::BlobPath("one", digest, protocol::BlobId::Partition(0)) +
                   " HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer " + token + "\r\n\r\n";
  const std::string end = "\r\n\r\n";
  for (const std::uint64_t every : { 997u, 331u, 101u, 53u, 29u, 17u, 7u })
  {
    this->faults->allocation.FailEvery(every, ENOMEM);
    for (int round = 0; round < 20; ++round)
    {
      TlsTestClient client(port);
      client.Send(ask);
      const auto answer = client.Receive(end);
      EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 ")) << answer;
    }
    // So that they are read again.
    fs::last_write_time(this->keys, fs::file_time_type::clock::now());
    serve.Signal(SIGHUP);
  }
  this->faults->Clear();
  TlsTestClient after(port);
  after.Send(ask);
  EXPECT_EQ(after.Receive(end).substr(0, 15), "HTTP/1.1 200 OK");
  serve.Signal(SIGTERM);
  EXPECT_EQ(serve.Wait(), 0);
}
