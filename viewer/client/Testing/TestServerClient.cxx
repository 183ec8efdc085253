// SPDX-License-Identifier: BSD-3-Clause
// Whole sessions over loopback: with our server, over a connection that breaks, and with a server
// of plain files.
#include "viewer/client/ServerClient.h"

#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "server/access/Testing/ForgedToken.h"
#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <list>
#include <mutex>
#include <thread>

using namespace kdstream;
using boost::asio::ip::tcp;
using kdstream::testing::MemoryServer;
using kdstream::testing::ServedTorus;
using kdstream::testing::TorusCatalog;
namespace http = boost::beast::http;

namespace
{

// Accepts connections on loopback and serves each in a thread of its own.
class Acceptor
{
public:
  using Serve = std::function<void(tcp::socket&)>;
  explicit Acceptor(Serve serve)
    : Listening(this->Context, { boost::asio::ip::address_v4::loopback(), 0 })
    , Port(this->Listening.local_endpoint().port())
    , Accepting([this, serve] { this->Accept(serve); })
  {
  }
  ~Acceptor() { this->Stop(); }
  void Stop()
  {
    if (!this->Stopped.exchange(true))
    {
      boost::system::error_code error;
      tcp::socket knock(this->Context); // wakes up accept
      knock.connect({ boost::asio::ip::address_v4::loopback(), this->Port }, error);
      this->Accepting.join();
      this->Listening.close(error);
      for (tcp::socket& socket : this->Sockets)
      {
        socket.shutdown(tcp::socket::shutdown_both, error);
      }
      for (std::thread& thread : this->Threads)
      {
        thread.join();
      }
    }
  }
  std::string Url() const { return "http://127.0.0.1:" + std::to_string(this->Port); }

private:
  void Accept(const Serve& serve)
  {
    for (;;)
    {
      tcp::socket& socket = this->Sockets.emplace_back(this->Context);
      boost::system::error_code error;
      this->Listening.accept(socket, error);
      if (this->Stopped)
      {
        return;
      }
      this->Threads.emplace_back([&socket, serve] { serve(socket); });
    }
  }
  boost::asio::io_context Context;
  tcp::acceptor Listening;
  std::uint16_t Port;
  std::atomic<bool> Stopped{ false };
  std::list<tcp::socket> Sockets;
  std::list<std::thread> Threads;
  std::thread Accepting;
};

// Copies from one socket to the other until an end, or until `budget` bytes are used up.
void Copy(tcp::socket& from, tcp::socket& to, std::atomic<std::int64_t>& budget)
{
  boost::system::error_code error;
  std::array<char, 4096> buffer;
  while (!error)
  {
    const std::size_t bytes = from.read_some(boost::asio::buffer(buffer), error);
    budget -= static_cast<std::int64_t>(bytes);
    if (error || budget < 0)
    {
      break;
    }
    boost::asio::write(to, boost::asio::buffer(buffer.data(), bytes), error);
  }
  from.shutdown(tcp::socket::shutdown_both, error);
  to.shutdown(tcp::socket::shutdown_both, error);
}

// Passes on connections to `port`, and cuts each one when its budget of bytes has come through.
Acceptor::Serve ProxyTo(std::uint16_t port, std::function<std::int64_t()> budgetOfNext)
{
  return [port, budgetOfNext](tcp::socket& client)
  {
    boost::asio::io_context context;
    tcp::socket server(context);
    boost::system::error_code error;
    server.connect({ boost::asio::ip::address_v4::loopback(), port }, error);
    std::atomic<std::int64_t> down{ budgetOfNext() }, up{ 1 << 30 };
    std::thread upwards([&] { Copy(client, server, up); });
    Copy(server, client, down);
    upwards.join();
  };
}

// Serves the torus's blobs by GET, like a static host, without a stream.
void ServeFiles(tcp::socket& socket)
{
  boost::beast::flat_buffer buffer;
  boost::system::error_code error;
  for (;;)
  {
    http::request<http::empty_body> request;
    http::read(socket, buffer, request, error);
    if (error)
    {
      return;
    }
    http::response<http::string_body> response(http::status::not_found, 11);
    const std::string target(request.target());
    const auto path = protocol::ParseResourcePath(target);
    if (path)
    {
      response.result(http::status::ok);
      const auto& model = ServedTorus().Description();
      using Kind = protocol::ResourcePath::Kind;
      if (path->kind == Kind::ModelList)
      {
        response.body() = WriteModelList({ Summarize(model) });
      }
      else if (path->kind == Kind::Model)
      {
        response.body() = WriteModel(model);
      }
      else
      {
        const auto& bytes = ServedTorus().Blob(path->blob);
        response.body().assign(bytes.begin(), bytes.end());
      }
    }
    response.prepare_payload();
    http::write(socket, response, error);
  }
}

void Exchange(ServerClient& client, ViewerSession& session)
{
  for (;;)
  {
    for (const ClientEvent& event : client.Take())
    {
      Deliver(event, session);
    }
    for (const SessionRequest& request : session.TakeRequests())
    {
      client.Send(request);
    }
    session.BeginFrame();
    if (session.IsIdle())
    {
      return;
    }
    client.Wait(std::chrono::seconds(1));
  }
}

void DoubleTap(ViewerSession& session, double time, double x, double y)
{
  for (const double t : { time, time + 0.2 })
  {
    session.HandleTouches({ t, { { 1, x, y } } });
    session.HandleTouches({ t + 0.05, {} });
  }
}

// Browses, then picks a region on the ring.
void Walk(ServerClient& client, ViewerSession& session)
{
  session.SetModels(client.Models());
  session.Resize({ 800, 600, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  Exchange(client, session);
  DoubleTap(session, 1, 600, 300);
  Exchange(client, session);
}

Surface WalkInMemory()
{
  MemoryServer server = ServedTorus();
  ViewerSession session;
  session.Resize({ 800, 600, 1 });
  EXPECT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  DoubleTap(session, 1, 600, 300);
  server.Serve(session);
  return session.Scene().surface->Whole();
}

void ExpectWholeWalk(const ViewerSession& session)
{
  const ViewerStatus status = session.GetStatus();
  EXPECT_EQ(status.error, "");
  ASSERT_TRUE(status.region);
  EXPECT_GT(status.region->shown, 1u);
  EXPECT_EQ(status.region->shown, status.region->partitions);
  const Surface expected = WalkInMemory();
  EXPECT_EQ(session.Scene().surface->Whole().points, expected.points);
  EXPECT_EQ(session.Scene().surface->Whole().triangles, expected.triangles);
}

class TestServerClient : public ::testing::Test
{
protected:
  TestServerClient() { this->Server = std::move(*HttpServer::Start(this->Models, {})); }
  TorusCatalog Models;
  std::unique_ptr<HttpServer> Server;
};

TEST_F(TestServerClient, StreamsARegion)
{
  auto client = ServerClient::Connect(this->Server->Url());
  ASSERT_TRUE(client) << client.GetError().message;
  ASSERT_EQ((*client)->Models().size(), 1u);
  EXPECT_EQ((*client)->Models()[0].id, "torus");
  ViewerSession session;
  Walk(**client, session);
  ExpectWholeWalk(session);
  for (const BlobStatistics& blob : session.Statistics())
  {
    EXPECT_GE(blob.transmissionSeconds, 0);
  }
}

TEST_F(TestServerClient, GetsARegionFromAHostOfPlainFiles)
{
  Acceptor files(ServeFiles);
  auto client = ServerClient::Connect(files.Url());
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  Walk(**client, session);
  ExpectWholeWalk(session);
}

TEST_F(TestServerClient, ALineThatBreaksOftenStillBringsEverything)
{
  // Each connection is cut after some bytes, in the middle of a frame. Because it has made
  // progress, the client connects again at once.
  std::atomic<std::int64_t> connections{ 0 };
  Acceptor proxy(ProxyTo(
    this->Server->Port(), [&connections] { return std::int64_t{ 20000 } + 7001 * connections++; }));
  auto client = ServerClient::Connect(proxy.Url());
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  Walk(**client, session);
  ExpectWholeWalk(session);
  EXPECT_GT(connections, 3);
}

TEST_F(TestServerClient, ALostServerIsAnErrorWithAReason)
{
  auto client = ServerClient::Connect(this->Server->Url());
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  session.Resize({ 800, 600, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  Exchange(**client, session);
  this->Server.reset(); // the connection ends, and there is no new one
  DoubleTap(session, 1, 600, 300);
  Exchange(**client, session);
  const std::string error = session.GetStatus().error;
  EXPECT_NE(error.find("the connection to 127.0.0.1:"), std::string::npos) << error;
  EXPECT_NE(error.find(" was lost: "), std::string::npos) << error;
  EXPECT_GT(session.GetStatus().triangles, 0u); // what was shown stays visible
}

TEST_F(TestServerClient, ADamagedBlobIsNamedAndTheRestIsShown)
{
  ViewerSession first;
  {
    auto client = ServerClient::Connect(this->Server->Url());
    ASSERT_TRUE(client);
    Walk(**client, first);
  }
  const NodeId cell = first.GetStatus().region->cell;
  const auto blob =
    protocol::BlobId::Partition(cell - (NodeId{ 1 } << ServedTorus().Codec().depths.partition));
  this->Models.model->damaged = blob;
  auto client = ServerClient::Connect(this->Server->Url());
  ASSERT_TRUE(client);
  ViewerSession session;
  Walk(**client, session);
  const ViewerStatus status = session.GetStatus();
  EXPECT_NE(status.error.find(protocol::BlobName(blob)), std::string::npos) << status.error;
  EXPECT_EQ(status.region->shown + 1, status.region->partitions);
}

TEST_F(TestServerClient, CancelledRequestsEnd)
{
  auto client = ServerClient::Connect(this->Server->Url());
  ASSERT_TRUE(client);
  for (int i = 0; i < 20; ++i)
  {
    ViewerSession session;
    session.Resize({ 800, 600, 1 });
    ASSERT_TRUE(session.SelectModel("torus"));
    Exchange(**client, session);
    // Taps at several places before anything has arrived.
    for (int k = 0; k < 5; ++k)
    {
      DoubleTap(session, 1 + k, k % 2 == 0 ? 600 : 200, 300);
      for (const SessionRequest& request : session.TakeRequests())
      {
        (*client)->Send(request);
      }
    }
    Exchange(**client, session);
    const ViewerStatus status = session.GetStatus();
    EXPECT_EQ(status.error, "");
    ASSERT_TRUE(status.region);
    EXPECT_EQ(status.region->shown, status.region->partitions);
  }
}

// A server whose clients need tokens.
class TestClientWithToken : public ::testing::Test
{
protected:
  TestClientWithToken()
  {
    HttpServerOptions options;
    options.guard = this->Guard;
    this->Server = std::move(*HttpServer::Start(this->Models, options));
  }
  static std::string Token(const std::string& detail)
  {
    return forged::Token(
      forged::header, R"({"sub":"ann","exp":2000,"models":"*","detail":")" + detail + "\"}");
  }
  TorusCatalog Models;
  std::atomic<std::int64_t> Time{ 1000 };
  std::shared_ptr<TokenGuard> Guard =
    std::make_shared<TokenGuard>(forged::Keys(), [this] { return this->Time.load(); });
  std::unique_ptr<HttpServer> Server;
};

TEST_F(TestClientWithToken, GetsWhatItAllows)
{
  auto client = ServerClient::Connect(this->Server->Url(), Token("regions"));
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  Walk(**client, session);
  ExpectWholeWalk(session);
}

// What the client may not have is not requested, unless the user asks for it: then there is a
// message.
TEST_F(TestClientWithToken, ShowsTheLevelsWhereItMayHaveNoMore)
{
  auto client = ServerClient::Connect(this->Server->Url(), Token("levels"));
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  session.SetModels((*client)->Models());
  session.Resize({ 800, 600, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  Exchange(**client, session);
  session.Zoom(30, 600, 300);
  Exchange(**client, session);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_GT(session.GetStatus().shownLevel, PreviewLevel(ServedTorus().Description()));
  for (const auto& name : this->Models.model->TakeRead())
  {
    EXPECT_NE(name.substr(0, 10), "partitions");
  }
  DoubleTap(session, 1, 600, 300);
  Exchange(**client, session);
  EXPECT_NE(
    session.GetStatus().error.find("the token only allows the levels of torus"), std::string::npos)
    << session.GetStatus().error;
  EXPECT_GT(session.Scene().surface->Whole().triangles.size(), 0u) << "what there is stays";
}

// Neither in view mode nor in level mode is anything finer requested or missed.
TEST_F(TestClientWithToken, ShowsThePreviewWhereItMayHaveNoMore)
{
  auto client = ServerClient::Connect(this->Server->Url(), Token("preview"));
  ASSERT_TRUE(client) << client.GetError().message;
  for (const auto mode : { DetailMode::View, DetailMode::Level })
  {
    ViewerSession session;
    session.SetModels((*client)->Models());
    session.SetDetail(mode);
    session.Resize({ 800, 600, 1 });
    ASSERT_TRUE(session.SelectModel("torus"));
    session.EnterFullScreen();
    Exchange(**client, session);
    session.Zoom(30, 600, 300);
    Exchange(**client, session);
    EXPECT_EQ(session.GetStatus().error, "");
    EXPECT_EQ(session.GetStatus().shownLevel, PreviewLevel(ServedTorus().Description()));
    for (const auto& name : this->Models.model->TakeRead())
    {
      EXPECT_EQ(name, "levels/11/1");
    }
    DoubleTap(session, 1, 600, 300);
    Exchange(**client, session);
    EXPECT_NE(session.GetStatus().error.find("the token only allows the preview of torus"),
      std::string::npos)
      << session.GetStatus().error;
  }
}

TEST_F(TestClientWithToken, SaysWhyItIsRefused)
{
  const auto without = ServerClient::Connect(this->Server->Url());
  ASSERT_FALSE(without);
  EXPECT_NE(without.GetError().message.find("the server says 401: this server requires a token"),
    std::string::npos)
    << without.GetError().message;
  for (const std::string wrong : { "a b", "a\r\nX: y", "a:b" })
  {
    const auto refused = ServerClient::Connect(this->Server->Url(), wrong);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.GetError().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(refused.GetError().message.find(wrong), std::string::npos) << "it is a secret";
  }
  auto client = ServerClient::Connect(this->Server->Url(), Token("regions"));
  ASSERT_TRUE(client);
  ViewerSession session;
  Walk(**client, session);
  this->Time = 2000;
  session.EnterFullScreen();
  session.SetDetail(DetailMode::Full);
  Exchange(**client, session);
  EXPECT_NE(session.GetStatus().error.find("expired"), std::string::npos)
    << session.GetStatus().error;
}

// A server that is being restarted answers that it is busy.
TEST_F(TestServerClient, ABusyServerIsAskedForItsModelsAgain)
{
  std::atomic<int> asked{ 0 };
  const auto toServer = ProxyTo(this->Server->Port(), [] { return std::int64_t{ 1 } << 30; });
  Acceptor busy(
    [&](tcp::socket& socket)
    {
      if (asked++ != 0)
      {
        toServer(socket);
        return;
      }
      const std::string refusal =
        "HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\n"
        "Content-Length: 0\r\n\r\n";
      boost::system::error_code error;
      boost::asio::write(socket, boost::asio::buffer(refusal), error);
      socket.shutdown(tcp::socket::shutdown_send, error);
    });
  auto client = ServerClient::Connect(busy.Url());
  ASSERT_TRUE(client) << client.GetError().message;
  EXPECT_EQ((*client)->Models().size(), 1u);
  ViewerSession session;
  Walk(**client, session);
  ExpectWholeWalk(session);
}

TEST_F(TestServerClient, SaysWhyThereIsNoConnection)
{
  std::string url;
  {
    Acceptor gone([](tcp::socket&) {});
    url = gone.Url();
  }
  const auto unreachable = ServerClient::Connect(url);
  ASSERT_FALSE(unreachable);
  EXPECT_NE(unreachable.GetError().message.find("cannot be reached"), std::string::npos);
  EXPECT_EQ(unreachable.GetError().code, ErrorCode::InputOutput);

  Acceptor garbage(
    [](tcp::socket& socket)
    {
      boost::system::error_code error;
      boost::asio::write(socket, boost::asio::buffer("SSH-2.0-nothing\r\n", 17), error);
      socket.shutdown(tcp::socket::shutdown_both, error);
    });
  EXPECT_FALSE(ServerClient::Connect(garbage.Url()));

  Acceptor other(
    [](tcp::socket& socket)
    {
      boost::system::error_code error;
      const std::string page = "HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nhello";
      boost::asio::write(socket, boost::asio::buffer(page), error);
    });
  const auto page = ServerClient::Connect(other.Url());
  ASSERT_FALSE(page);
  EXPECT_NE(page.GetError().message.find("is not a KdStream server"), std::string::npos)
    << page.GetError().message;
}

}
