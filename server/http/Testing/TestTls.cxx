// SPDX-License-Identifier: BSD-3-Clause
// HTTPS and the stream over TLS, with certificates made for the test.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/HttpServer.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/http/Testing/ScarceMemory.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/TlsTestClient.h"
#include "server/session/Testing/MemoryCatalog.h"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Tls : public testing::Test
{
protected:
  const fixtures::TemporaryFolder folder;
  const fs::path certificate = folder / "cert.pem", key = folder / "key.pem";
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 3, 100000);
  const std::string ask = "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n";
  const std::string upgrade = "GET /api/stream HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\n"
                              "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: kdstream.v2\r\n\r\n";
  HttpServerOptions options;

  void SetUp() override
  {
    std::signal(SIGPIPE, SIG_IGN); // clients write to connections that have ended
    WriteSelfSigned(this->certificate, this->key);
    this->options.tlsCertificate = this->certificate;
    this->options.tlsKey = this->key;
    this->options.drainTimeout = std::chrono::milliseconds(100);
  }

  std::unique_ptr<HttpServer> Start()
  {
    auto server = HttpServer::Start(this->catalog, this->options);
    EXPECT_TRUE(server) << server.GetError().message;
    return server ? std::move(*server) : nullptr;
  }

  static std::string Exchange(
    std::uint16_t port, const std::string& request, const std::string& end)
  {
    TlsTestClient client(port);
    client.Send(request);
    return client.Receive(end);
  }

  // A masked text frame, with a mask of zeros.
  static std::string Frame(const std::string& text)
  {
    std::string frame("\x81", 1);
    frame += static_cast<char>(0x80 | text.size());
    return frame + std::string(4, '\0') + text;
  }

  std::string Whole(const protocol::BlobId& id) const
  {
    const auto& bytes = *this->model->blobs.at(id);
    return { bytes.begin(), bytes.end() };
  }

  // Why a server does not start with these files; "" if it does.
  std::string Refusal(const fs::path& certificate_, const fs::path& key_) const
  {
    HttpServerOptions wrong;
    wrong.tlsCertificate = certificate_;
    wrong.tlsKey = key_;
    const auto server = HttpServer::Start(this->catalog, wrong);
    return server ? "none" : server.GetError().message;
  }
};

}

TEST_F(Tls, ServesHttps)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  EXPECT_EQ(server->Url(), "https://127.0.0.1:" + std::to_string(server->Port()));
  const auto answer = Exchange(server->Port(), this->ask, "ok\n");
  EXPECT_EQ(answer.substr(0, 15), "HTTP/1.1 200 OK") << answer;
}

TEST_F(Tls, SendsBrowsersHsts)
{
  const std::string field = "\r\nStrict-Transport-Security: max-age=31536000\r\n";
  {
    const auto server = this->Start();
    EXPECT_NE(Exchange(server->Port(), this->ask, "ok\n").find(field), std::string::npos);
    EXPECT_NE(Exchange(server->Port(), "nonsense\r\n\r\n", "}\n").find(field), std::string::npos);
  }
  this->options.strictTransport = std::chrono::seconds(0);
  const auto silent = this->Start();
  const auto answer = Exchange(silent->Port(), this->ask, "ok\n");
  EXPECT_EQ(answer.find("Strict-Transport-Security"), std::string::npos) << answer;
}

TEST_F(Tls, BlobsComeWhole)
{
  const auto server = this->Start();
  TlsTestClient client(server->Port());
  for (std::uint32_t p = 0; p < 8; ++p)
  {
    const auto id = protocol::BlobId::Partition(p);
    const auto whole = this->Whole(id);
    client.Send("GET " + protocol::BlobPath("dragon", this->model->Description().digest, id) +
                " HTTP/1.1\r\nHost: a\r\n\r\n");
    std::string head;
    while (!head.ends_with("\r\n\r\n"))
    {
      const auto byte = client.Receive(1);
      ASSERT_FALSE(byte.empty()) << head;
      head += byte;
    }
    EXPECT_EQ(client.Receive(whole.size()), whole) << p;
    client.ChangeKeys(); // the server has to answer this, too
  }
  client.Send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_TRUE(client.EndsProperly());
}

TEST_F(Tls, StreamsOverTls)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  const auto open = Frame(R"({"type":"open","request":1,"model":"dragon"})");
  TlsTestClient client(server->Port());
  client.Send(this->upgrade);
  EXPECT_EQ(client.Receive("\r\n\r\n").substr(0, 12), "HTTP/1.1 101");
  client.Send(open);
  EXPECT_NE(client.Receive("\"opened\"").find("\"opened\""), std::string::npos);
  client.ChangeKeys();
  client.Send(Frame(R"({"type":"region","request":2,"cell":1,"rings":0})"));
  const auto received = client.Receive("\"end\"");
  std::size_t bytes = 0;
  for (std::uint32_t p = 0; p < 8; ++p)
  {
    const auto whole = this->Whole(protocol::BlobId::Partition(p));
    bytes += whole.size();
    EXPECT_NE(received.find(whole.substr(0, 60000)), std::string::npos) << p;
  }
  EXPECT_GT(received.size(), bytes);
  // Frames that are sent before the upgrade has been answered are refused, not mixed up.
  EXPECT_EQ(
    Exchange(server->Port(), this->upgrade + open, "\r\n\r\n").substr(0, 12), "HTTP/1.1 400");
}

// All connections end with the server. One that was left would keep the client waiting.
TEST_F(Tls, EndsWhileAClientTakesNothing)
{
  const auto blob =
    protocol::BlobPath("dragon", this->model->Description().digest, protocol::BlobId::Partition(0));
  auto server = this->Start();
  TlsTestClient client(server->Port());
  for (int i = 0; i < 300; ++i) // more than the buffers of sockets hold
  {
    client.Send("GET " + blob + " HTTP/1.1\r\nHost: a\r\n\r\n");
  }
  EXPECT_EQ(client.Receive("\r\n\r\n").substr(0, 15), "HTTP/1.1 200 OK");
  server.reset(); // returns, however much of the answers has been sent
  while (!client.Receive(1).empty())
  {
  }
}

TEST_F(Tls, SpeaksNothingElse)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  EXPECT_FALSE(HttpTestClient(server->Port()).Get("/healthz"));
}

TEST_F(Tls, SurvivesHostileHandshakes)
{
  const auto server = this->Start();
  // The first message of a client.
  const std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context(
    SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  const std::unique_ptr<SSL, void (*)(SSL*)> session(SSL_new(context.get()), SSL_free);
  BIO* out = BIO_new(BIO_s_mem());
  SSL_set_bio(session.get(), BIO_new(BIO_s_mem()), out);
  SSL_connect(session.get());
  std::string hello(BIO_ctrl_pending(out), '\0');
  BIO_read(out, hello.data(), static_cast<int>(hello.size()));
  ASSERT_GT(hello.size(), 100u);

  protocol::RandomMessages random(23);
  for (int i = 0; i < 300; ++i)
  {
    HttpTestClient client(server->Port());
    client.Send(i % 3 == 0 ? hello + random.Mutated(hello) : random.Mutated(hello));
  }
  EXPECT_EQ(Exchange(server->Port(), this->ask, "ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Tls, GoesOnListeningWhereThereIsNoMemoryForAConnection)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  for (long n = 0; n < 2; ++n) // TLS's data of the connection, and the connection itself
  {
    const ScarceMemory scarce(n, ScarceMemory::Where::OtherThreads, 4096);
    EXPECT_EQ(Exchange(server->Port(), this->ask, "ok\n"), "");
    EXPECT_GE(scarce.AwaitFailure(), 4096u);
  }
  EXPECT_EQ(Exchange(server->Port(), this->ask, "ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Tls, ReadsItsCertificateAgainOnReload)
{
  WriteSelfSigned(this->certificate, this->key, "first");
  const auto server = this->Start();
  TlsTestClient before(server->Port());
  EXPECT_EQ(before.ServerName(), "first");
  WriteSelfSigned(this->certificate, this->key, "second");
  EXPECT_EQ(TlsTestClient(server->Port()).ServerName(), "first") << "not yet";
  ASSERT_TRUE(server->ReloadTls());
  EXPECT_EQ(TlsTestClient(server->Port()).ServerName(), "second");
  before.Send(this->ask);
  EXPECT_EQ(before.Receive("ok\n").substr(0, 15), "HTTP/1.1 200 OK") << "earlier ones go on";

  // A file that is not a certificate, or not the certificate of this key, is not used.
  std::ofstream(this->certificate) << "half a certif";
  auto kept = server->ReloadTls();
  EXPECT_TRUE(fixtures::FailsAt(kept, ErrorCode::InvalidInput, this->certificate.string() + ": "));
  EXPECT_EQ(TlsTestClient(server->Port()).ServerName(), "second");
  WriteCertificate(this->certificate, MakeKey().get(), "third");
  kept = server->ReloadTls();
  EXPECT_TRUE(fixtures::FailsAt(kept, ErrorCode::InvalidInput, this->key.string() + ": "));
  EXPECT_TRUE(fixtures::FailsAt(kept, ErrorCode::InvalidInput, this->certificate.string()));
  EXPECT_EQ(TlsTestClient(server->Port()).ServerName(), "second");
  fs::remove(this->key);
  EXPECT_FALSE(server->ReloadTls());
  EXPECT_EQ(Exchange(server->Port(), this->ask, "ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Tls, AProxysHeaderComesBeforeIt)
{
  this->options.trustedProxies = { "127.0.0.1" };
  this->options.proxyProtocol = true;
  const auto server = this->Start();
  EXPECT_FALSE(TlsTestClient(server->Port()).IsConnected());
  TlsTestClient client(server->Port(), "PROXY TCP4 1.2.3.4 5.6.7.8 50000 443\r\n");
  ASSERT_TRUE(client.IsConnected());
  client.Send(this->ask);
  EXPECT_EQ(client.Receive("ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Tls, NeedsACertificateAndItsKey)
{
  EXPECT_TRUE(fixtures::Mentions(
    this->Refusal(this->key, this->key), { this->key.string() + ": ", "no certificate" }));
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(this->certificate, this->certificate),
    { this->certificate.string() + ": ", "no private key" }));
}

TEST_F(Tls, SaysWhatIsWrongWithItsFiles)
{
  const auto missing = this->folder / "none.pem", other = this->folder / "other.pem";
  EXPECT_TRUE(
    fixtures::Mentions(this->Refusal(missing, this->key), { missing.string() + ": ", "No such" }));
  const auto another = MakeKey();
  WriteKey(other, another.get());
  EXPECT_TRUE(fixtures::Mentions(this->Refusal(this->certificate, other),
    { other.string() + ": ", this->certificate.string() }));
  WriteKey(other, another.get(), "secret"); // the server must not ask the terminal for it
  EXPECT_TRUE(fixtures::Mentions(
    this->Refusal(this->certificate, other), { other.string() + ": ", "no private key" }));
}
