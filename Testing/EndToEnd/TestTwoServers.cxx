// SPDX-License-Identifier: BSD-3-Clause
// Two servers with one folder behind nginx, configured as in deploy/kdstream.nginx.conf. One is
// killed while it sends data to clients, and no client loses anything.
#include "Testing/EndToEnd/StreamTap.h"
#include "Testing/Fixtures/Eventually.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/codec/Seal.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/model/ModelJson.h"
#include "server/app/Testing/ServeProcess.h"
#include "server/http/Testing/HttpTestClient.h"
#include "viewer/client/ServerClient.h"

#include <algorithm>
#include <fstream>
#include <set>

using namespace kdstream;
using boost::asio::ip::tcp;
using protocol::BlobId;

namespace
{

const std::string nginx = KDSTREAM_NGINX; // "": not installed

// The text with each `from` replaced. Fails if one does not occur.
std::string Replaced(
  std::string text, const std::vector<std::pair<std::string, std::string>>& replacements)
{
  for (const auto& [from, to] : replacements)
  {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << "the example has no " << from;
    at == std::string::npos ? text : text.replace(at, from.size(), to);
  }
  return text;
}

// nginx in front of two servers, configured as in the example except for paths and ports.
class Proxy
{
public:
  Proxy(const fs::path& folder, std::uint16_t first, std::uint16_t second)
    : Cache(folder / "cache")
    , Port(FreePort())
    , Process_({ "-e", folder / "nginx.log", "-c", this->Write(folder, first, second) }, nginx)
  {
    EXPECT_TRUE(fixtures::Eventually([&] { return HttpTestClient::Connects(this->Port); }));
  }

  // nginx is not killed at once, because its workers would remain.
  ~Proxy()
  {
    this->Process_.Signal(SIGTERM);
    EXPECT_EQ(this->Process_.Wait(), 0);
  }

  const fs::path Cache;
  const std::uint16_t Port;

private:
  // Finds a free port, because nginx cannot report its own.
  static std::uint16_t FreePort()
  {
    boost::asio::io_context context;
    return tcp::acceptor(context, { boost::asio::ip::address_v4::loopback(), 0 })
      .local_endpoint()
      .port();
  }
  std::string Write(const fs::path& folder, std::uint16_t first, std::uint16_t second) const
  {
    // sndbuf: little data is in flight while a client does not read.
    const auto site = Replaced(fixtures::ReadWhole(KDSTREAM_NGINX_EXAMPLE),
      { { "127.0.0.1:8701", "127.0.0.1:" + std::to_string(first) },
        { "127.0.0.1:8702", "127.0.0.1:" + std::to_string(second) },
        { "/var/lib/nginx/kdstream", this->Cache },
        { "listen 80;", "listen 127.0.0.1:" + std::to_string(this->Port) + " sndbuf=8k;" } });
    const auto file = folder / "nginx.conf";
    std::ofstream text(file);
    text << (::geteuid() == 0 ? "user root; " : "") << "daemon off; pid "
         << (folder / "pid").string() << ";\nevents { }\nhttp {\naccess_log off;\n";
    for (const char* const kind : { "client_body", "proxy", "fastcgi", "uwsgi", "scgi" })
    {
      text << kind << "_temp_path " << (folder / kind).string() << ";\n";
    }
    text << site << "}\n";
    return file;
  }

  Process Process_;
};

// The blobs that one client has received.
struct Viewed
{
  std::set<BlobId> blobs;
  std::size_t twice = 0, damaged = 0, refused = 0; // refused: requests that the quota refused
  std::string trouble;                             // anything else that went wrong
};

class TwoServers : public Serve
{
protected:
  const fs::path keys = this->folder / "tokens.json";

  void SetUp() override
  {
    if (nginx.empty())
    {
      GTEST_SKIP() << "nginx is not installed";
    }
    Serve::SetUp();
    std::ofstream(this->keys) << R"({"secret":"0123456789abcdef0123456789abcdef"})";
    fs::permissions(this->keys, fs::perms::owner_read | fs::perms::owner_write);
    BuildOptions options;
    options.tree.verticesPerPartition = 800;
    options.bits = 0;
    ASSERT_TRUE(
      BuildStore(fixtures::Torus(600, 300), "ring.ply", this->stores / "ring.kds", options));
  }

  // Starts both servers, with nginx in front of them.
  void Start(const std::vector<std::string>& more)
  {
    std::vector<std::string> arguments{ this->stores, "--port", "0", "--trusted-proxy",
      "127.0.0.1" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    for (std::size_t i = 0; i < 2; ++i)
    {
      this->servers[i].emplace(arguments);
      this->ports[i] = this->servers[i]->Port();
    }
    this->proxy.emplace(this->folder, this->ports[0], this->ports[1]);
  }

  std::string Token(const std::string& subject) const
  {
    Process process({ "token", "--tokens", this->keys, "--sub", subject, "--models", "*",
      "--detail", "regions" });
    auto token = process.OutLine();
    EXPECT_EQ(process.Wait(), 0);
    return token;
  }
  static std::string Bearer(const std::string& token)
  {
    return "Authorization: Bearer " + token + "\r\n";
  }
  HttpTestClient::Response Get(const std::string& target, const std::string& fields = "") const
  {
    const auto answer = HttpTestClient(this->proxy->Port).Get(target, fields);
    return answer ? *answer : HttpTestClient::Response();
  }
  ModelDescription Model(const std::string& fields = "") const
  {
    const auto model = ParseModel(this->Get("/api/models/ring/model.json", fields).body);
    EXPECT_TRUE(model);
    return model ? *model : ModelDescription();
  }
  // A counter of one of the servers, requested from that server directly.
  int Metric(std::size_t server, const std::string& name) const
  {
    const auto text = HttpTestClient(this->ports[server]).Get("/metrics")->body;
    const auto at = text.find("\n" + name + " ");
    return at == std::string::npos ? -1 : std::atoi(text.c_str() + at + name.size() + 2);
  }

  std::array<std::optional<Process>, 2> servers;
  std::array<std::uint16_t, 2> ports{};
  std::optional<Proxy> proxy; // ends before the servers
};

std::vector<BlobId> FinestLevel(const ModelDescription& model)
{
  const unsigned level = model.depths.finest;
  const auto first = NodeId{ 1 } << PieceDepth(Resolution::Level(level), model.depths);
  std::vector<BlobId> blobs;
  for (NodeId node = first; node < 2 * first; ++node)
  {
    blobs.push_back(BlobId::LevelPiece(static_cast<std::uint8_t>(level), node));
  }
  return blobs;
}

// A client with many requests at once. For each request it keeps the number of outstanding blobs.
class Viewer
{
public:
  // wanted: the blobs of each request.
  Viewed View(const std::string& url, const std::string& token,
    const std::vector<std::vector<BlobId>>& wanted)
  {
    const auto client = ServerClient::Connect(url, token);
    if (!client)
    {
      this->Seen.trouble = client.GetError().message;
      return this->Seen;
    }
    SessionRequest request;
    request.id = 1;
    request.model = "ring";
    (*client)->Send(request);
    request.kind = SessionRequest::Kind::Blobs;
    for (const auto& blobs : wanted)
    {
      ++request.id;
      request.blobs = blobs;
      this->Outstanding[request.id] = blobs.size();
      (*client)->Send(request);
    }
    while (this->Seen.trouble.empty() && !this->Outstanding.empty())
    {
      (*client)->Wait(std::chrono::milliseconds(1000));
      for (const ClientEvent& event : (*client)->Take())
      {
        this->Note(event);
      }
    }
    return this->Seen;
  }

private:
  void Note(const ClientEvent& event)
  {
    using Kind = ClientEvent::Kind;
    if (event.kind == Kind::Blob)
    {
      this->Seen.twice += this->Seen.blobs.insert(event.blob).second ? 0 : 1;
      this->Seen.damaged += IsSealed(event.bytes) ? 0 : 1;
      --this->Outstanding[event.request] == 0 ? this->Outstanding.erase(event.request) : 0;
    }
    else if (event.kind == Kind::RequestFailed &&
             event.message.find("the quota of ") != std::string::npos)
    {
      ++this->Seen.refused;
      this->Outstanding.erase(event.request);
    }
    else if (event.kind != Kind::Opened)
    {
      this->Seen.trouble =
        event.message + " (" + std::to_string(static_cast<int>(event.kind)) + ")";
    }
  }

  std::map<std::uint32_t, std::size_t> Outstanding;
  Viewed Seen;
};

// The requests for a whole model: the finest level at once, and then the original in small
// requests.
std::vector<std::vector<BlobId>> AllOf(const ModelDescription& model)
{
  std::vector<std::vector<BlobId>> wanted{ FinestLevel(model) };
  for (std::uint32_t partition = 0; partition < model.partitions; ++partition)
  {
    partition % 8 == 0 ? void(wanted.emplace_back()) : void();
    wanted.back().push_back(BlobId::Partition(partition));
  }
  return wanted;
}

// The clients of one load: two for each token; one of the two begins at the end.
struct Crowd
{
  Crowd(std::uint16_t proxy, const ModelDescription& model, const std::vector<std::string>& tokens)
  {
    this->levels = FinestLevel(model);
    auto wanted = AllOf(model);
    constexpr std::size_t begun = 10; // partitions
    this->views.resize(2 * tokens.size());
    for (std::size_t i = 0; i < this->views.size(); ++i)
    {
      this->taps.emplace_back(proxy, this->levels.size() + begun);
      this->threads.emplace_back(
        [this, i, token = tokens[i / 2], wanted, url = this->taps.back().Url()]() mutable
        {
          if (i % 2 == 1)
          {
            std::reverse(wanted.begin() + 1, wanted.end());
          }
          this->views[i] = Viewer().View(url, token, wanted);
        });
    }
  }
  void AwaitHold()
  {
    std::for_each(this->taps.begin(), this->taps.end(), [](StreamTap& tap) { tap.AwaitHold(); });
  }
  void LetThrough()
  {
    std::for_each(this->taps.begin(), this->taps.end(), [](StreamTap& tap) { tap.LetThrough(); });
  }
  // Whether each client has connected once more, after the connections for its list of models and
  // its stream.
  bool HaveAllComeBack() const
  {
    return std::all_of(this->taps.begin(), this->taps.end(),
      [](const StreamTap& tap) { return tap.Connections() > 2; });
  }
  void Finish()
  {
    this->LetThrough();
    std::for_each(
      this->threads.begin(), this->threads.end(), [](std::thread& thread) { thread.join(); });
  }

  std::vector<BlobId> levels;
  std::list<StreamTap> taps;
  std::vector<Viewed> views;
  std::vector<std::thread> threads;
};

// The first line of the answer to these bytes, which are sent from an address of this machine.
std::string Ask(std::uint16_t port, const std::string& from, const std::string& bytes)
{
  boost::asio::io_context context;
  tcp::socket socket(context, { boost::asio::ip::make_address(from), 0 });
  socket.connect({ boost::asio::ip::address_v4::loopback(), port });
  boost::asio::write(socket, boost::asio::buffer(bytes));
  std::string line;
  boost::system::error_code error;
  for (char c = 0; boost::asio::read(socket, boost::asio::buffer(&c, 1), error) == 1 && c != '\r';)
  {
    line += c;
  }
  return line;
}

}

TEST_F(TwoServers, OneIsKilledAndEveryClientGoesOnThroughTheOther)
{
  this->Start({ "--tokens", this->keys, "--quota-file", this->folder / "quotas.db",
    "--quota-partitions", "60" });
  std::vector<std::string> tokens;
  for (const char* const subject : { "ann", "bob", "cem", "dia" })
  {
    tokens.push_back(this->Token(subject));
  }
  const auto model = this->Model(this->Bearer(tokens[0]));
  const auto most = model.partitions * 6 / 10;
  Crowd crowd(this->proxy->Port, model, tokens);
  crowd.AwaitHold();
  const int moving = this->Metric(0, "kdstream_streams");
  const int staying = this->Metric(1, "kdstream_streams");
  EXPECT_EQ(moving + staying, 8);
  EXPECT_GT(moving, 0);
  EXPECT_GT(staying, 0);

  this->servers[0]->Signal(SIGKILL);
  EXPECT_EQ(this->servers[0]->Wait(), -SIGKILL);
  crowd.Finish();

  EXPECT_EQ(this->Metric(1, "kdstream_streams_total"), moving + staying)
    << "all that were at the other have come";
  auto tap = crowd.taps.begin();
  std::array<std::set<BlobId>, 4> had;
  for (std::size_t i = 0; i < crowd.views.size(); ++i, ++tap)
  {
    const Viewed& viewed = crowd.views[i];
    EXPECT_EQ(viewed.trouble, "");
    EXPECT_EQ(viewed.damaged, 0u);
    EXPECT_EQ(viewed.twice, 0u);
    EXPECT_TRUE(std::all_of(crowd.levels.begin(), crowd.levels.end(),
      [&viewed](const BlobId& blob) { return viewed.blobs.count(blob) == 1; }));
    const auto counts = tap->Counts();
    EXPECT_EQ(counts.size(), viewed.blobs.size());
    EXPECT_TRUE(std::all_of(
      counts.begin(), counts.end(), [](const auto& entry) { return entry.second == 1; }))
      << "something came whole a second time";
    had[i / 2].insert(viewed.blobs.begin(), viewed.blobs.end());
  }
  for (std::size_t i = 0; i < had.size(); ++i)
  {
    EXPECT_EQ(had[i].size() - crowd.levels.size(), most) << "both servers together";
    std::uint32_t lacking = 0;
    while (had[i].count(BlobId::Partition(lacking)) != 0)
    {
      ++lacking;
    }
    const auto status = [&](std::uint32_t partition)
    {
      return this
        ->Get(protocol::BlobPath("ring", model.digest, BlobId::Partition(partition)),
          this->Bearer(tokens[i]))
        .status;
    };
    EXPECT_EQ(status(lacking), 403u);
    EXPECT_EQ(status(had[i].rbegin()->number), 200u);
  }
}

// nginx asks the other server if one has ended, or says that it will end soon.
TEST_F(TwoServers, OneThatStopsIsPassedOver)
{
  this->Start({ "--drain", "100000" });
  const auto model = this->Model();
  StreamTestClient deaf(this->ports[0]);
  ASSERT_TRUE(deaf.Open());
  deaf.Ask({ 1, protocol::OpenRequest{ "ring" } });
  ASSERT_TRUE(deaf.Await(1).opened);
  for (std::uint32_t request = 2; request < 12; ++request) // more than fit into buffers
  {
    deaf.Ask({ request, protocol::BlobsRequest{ FinestLevel(model) } });
  }
  ASSERT_TRUE(deaf.Receive());
  this->servers[0]->Signal(SIGTERM);
  EXPECT_TRUE(fixtures::Eventually(
    [&] { return HttpTestClient(this->ports[0]).Get("/readyz")->status != 200; }));
  EXPECT_EQ(HttpTestClient(this->ports[0]).Get("/api/models.json")->status, 503u);
  for (int i = 0; i < 20; ++i)
  {
    EXPECT_EQ(this->Get("/api/models.json").status, 200u);
    EXPECT_EQ(this->Get("/readyz").status, 200u);
  }
  this->servers[0]->Signal(SIGKILL);
  EXPECT_EQ(this->servers[0]->Wait(), -SIGKILL);
  for (int i = 0; i < 20; ++i)
  {
    EXPECT_EQ(this->Get("/api/models.json").status, 200u);
  }
}

// Clients wait until a server is there again.
TEST_F(TwoServers, ClientsWaitWhileBothAreGone)
{
  this->Start({});
  Crowd crowd(this->proxy->Port, this->Model(), { "" });
  crowd.AwaitHold();
  for (auto& server : this->servers)
  {
    server->Signal(SIGKILL);
    EXPECT_EQ(server->Wait(), -SIGKILL);
  }
  EXPECT_EQ(this->Get("/api/models.json").status, 502u);
  crowd.LetThrough();
  EXPECT_TRUE(fixtures::Eventually([&] { return crowd.HaveAllComeBack(); }));
  const auto port = std::to_string(this->ports[1]);
  const Process again({ this->stores, "--port", port, "--trusted-proxy", "127.0.0.1" });
  EXPECT_EQ(again.Port(), this->ports[1]);
  crowd.Finish();
  for (const Viewed& viewed : crowd.views)
  {
    EXPECT_EQ(viewed.trouble, "");
    EXPECT_EQ(viewed.blobs.size(), crowd.levels.size() + this->Model().partitions);
  }
}

TEST_F(TwoServers, BlobsOfOpenModelsAreKept)
{
  this->Start({});
  const auto path = protocol::BlobPath("ring", this->Model().digest, BlobId::Partition(7));
  const auto first = this->Get(path), second = this->Get(path);
  EXPECT_EQ(first.status, 200u);
  EXPECT_EQ(first.Field("X-Cache"), "MISS");
  EXPECT_EQ(second.Field("X-Cache"), "HIT");
  EXPECT_EQ(second.body, first.body);
  EXPECT_EQ(this->Get("/api/models/ring/model.json").Field("X-Cache"), "");
  EXPECT_EQ(this->Get("/metrics").status, 404u);
}

TEST_F(TwoServers, NothingIsKeptThatTakesAToken)
{
  this->Start({ "--tokens", this->keys });
  const auto bearer = this->Bearer(this->Token("ann"));
  const auto path = protocol::BlobPath("ring", this->Model(bearer).digest, BlobId::Partition(7));
  EXPECT_EQ(this->Get(path, bearer).status, 200u);
  EXPECT_NE(this->Get(path, bearer).Field("X-Cache"), "HIT");
  EXPECT_EQ(this->Get(path).status, 401u);
  const auto files = fs::recursive_directory_iterator(this->proxy->Cache);
  EXPECT_EQ(std::count_if(begin(files), end(files),
              [](const fs::directory_entry& entry) { return entry.is_regular_file(); }),
    0);
}

TEST_F(TwoServers, KnowWhoAsksForWhom)
{
  const auto log = this->folder / "access.log";
  this->Start({ "--allow-host", "models.example.org", "--access-log", log });
  const auto ask = [this](const std::string& host, const std::string& more)
  {
    return Ask(this->proxy->Port, "127.0.0.2",
      "GET /api/stream HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
  };
  const std::string forged = "X-Forwarded-For: 192.0.2.1\r\n";
  const std::string upgrade =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: kdstream.v2\r\n";
  EXPECT_EQ(ask("models.example.org:8080", forged).substr(0, 12), "HTTP/1.1 426");
  EXPECT_EQ(ask("elsewhere.example.org", forged).substr(0, 12), "HTTP/1.1 421");
  const std::string origin = "Origin: http://models.example.org:8080\r\n";
  EXPECT_EQ(ask("models.example.org:8080", upgrade + origin).substr(0, 12), "HTTP/1.1 101");
  EXPECT_EQ(ask("models.example.org", upgrade + origin).substr(0, 12), "HTTP/1.1 403");
  for (auto& server : this->servers)
  {
    server->Signal(SIGTERM);
    EXPECT_EQ(server->Wait(), 0);
  }
  const auto text = fixtures::ReadWhole(log);
  EXPECT_NE(text.find(" 127.0.0.2 \"GET /api/stream\" 426 "), std::string::npos) << text;
  EXPECT_EQ(text.find("192.0.2.1"), std::string::npos) << text;
}
