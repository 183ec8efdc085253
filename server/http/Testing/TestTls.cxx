// SPDX-License-Identifier: BSD-3-Clause
// HTTPS and the stream over TLS, with a certificate made for the test.
#include "server/http/HttpServer.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/http/Testing/ScarceMemory.h"
#include "server/session/Testing/MemoryCatalog.h"

#include <gtest/gtest.h>

#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <unistd.h>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Tls : public testing::Test
{
protected:
  fs::path folder = fs::temp_directory_path() / ("kdstream-tls-" + std::to_string(::getpid()));
  fs::path certificate = folder / "cert.pem", key = folder / "key.pem";
  MemoryCatalog catalog;

  void SetUp() override
  {
    this->catalog.Add("dragon", 1, 3, 1000);
    fs::create_directories(this->folder);
    EVP_PKEY* pair = EVP_RSA_gen(2048);
    X509* x509 = X509_new();
    ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509), 0);
    X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
    X509_set_pubkey(x509, pair);
    X509_NAME* name = X509_get_subject_name(x509);
    X509_NAME_add_entry_by_txt(
      name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
    X509_set_issuer_name(x509, name);
    X509_sign(x509, pair, EVP_sha256());
    std::FILE* file = std::fopen(this->certificate.c_str(), "w");
    PEM_write_X509(file, x509);
    std::fclose(file);
    file = std::fopen(this->key.c_str(), "w");
    PEM_write_PrivateKey(file, pair, nullptr, nullptr, 0, nullptr, nullptr);
    std::fclose(file);
    X509_free(x509);
    EVP_PKEY_free(pair);
  }
  void TearDown() override { fs::remove_all(this->folder); }

  std::unique_ptr<HttpServer> Start()
  {
    HttpServerOptions options;
    options.tlsCertificate = this->certificate;
    options.tlsKey = this->key;
    options.drainTimeout = std::chrono::milliseconds(100);
    auto server = HttpServer::Start(this->catalog, options);
    EXPECT_TRUE(server) << server.GetError().message;
    return server ? std::move(*server) : nullptr;
  }

  // What the server at `port` sends for `request`, until `end` has come or it stops sending.
  static std::string Talk(std::uint16_t port, const std::string& request, const std::string& end)
  {
    SSL_CTX* context = SSL_CTX_new(TLS_client_method());
    BIO* connection = BIO_new_ssl_connect(context);
    BIO_set_conn_hostname(connection, ("127.0.0.1:" + std::to_string(port)).c_str());
    std::string received;
    if (BIO_do_connect(connection) == 1)
    {
      BIO_write(connection, request.data(), static_cast<int>(request.size()));
      char bytes[4096];
      for (int n = 1; n > 0 && received.find(end) == std::string::npos;)
      {
        n = BIO_read(connection, bytes, sizeof bytes);
        received.append(bytes, static_cast<std::size_t>(std::max(n, 0)));
      }
    }
    BIO_free_all(connection);
    SSL_CTX_free(context);
    return received;
  }
};

}

TEST_F(Tls, ServesHttps)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  EXPECT_EQ(server->Url(), "https://127.0.0.1:" + std::to_string(server->Port()));
  const auto answer = Talk(server->Port(), "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n", "ok\n");
  EXPECT_EQ(answer.substr(0, 15), "HTTP/1.1 200 OK") << answer;
}

TEST_F(Tls, StreamsOverTls)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  const std::string ask = R"({"type":"open","request":1,"model":"lucy"})";
  std::string frame("\x81", 1); // a masked text frame, with a mask of zeros
  frame += static_cast<char>(0x80 | ask.size());
  frame += std::string(4, '\0') + ask;
  const std::string upgrade = "GET /api/stream HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\n"
                              "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: kdstream.v1\r\n\r\n";
  const auto answer = Talk(server->Port(), upgrade, "\r\n\r\n");
  EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 101") << answer;
  // Speaking before the answer has come is refused, not mixed up.
  EXPECT_EQ(Talk(server->Port(), upgrade + frame, "\r\n\r\n").substr(0, 12), "HTTP/1.1 400");
}

TEST_F(Tls, SpeaksNothingElse)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  EXPECT_FALSE(HttpTestClient(server->Port()).Get("/healthz"));
}

TEST_F(Tls, GoesOnListeningWhereThereIsNoMemoryForAConnection)
{
  const auto server = this->Start();
  ASSERT_TRUE(server);
  const std::string request = "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n";
  for (long n = 0; n < 3; ++n) // two buffers of the TLS stream, and the connection itself
  {
    const ScarceMemory scarce(n, ScarceMemory::Where::OtherThreads, 4096);
    std::signal(SIGPIPE, SIG_IGN); // the client writes to a connection that has ended
    EXPECT_EQ(Talk(server->Port(), request, "ok\n"), "");
    EXPECT_GE(scarce.AwaitFailure(), 4096u);
  }
  EXPECT_EQ(Talk(server->Port(), request, "ok\n").substr(0, 15), "HTTP/1.1 200 OK");
}

TEST_F(Tls, NeedsACertificateAndItsKey)
{
  HttpServerOptions options;
  options.tlsCertificate = this->key;
  options.tlsKey = this->key;
  const auto swapped = HttpServer::Start(this->catalog, options);
  ASSERT_FALSE(swapped);
  EXPECT_EQ(swapped.GetError().message, this->key.string() + ": holds no certificate in PEM");
  options.tlsCertificate = this->certificate;
  options.tlsKey = this->certificate;
  const auto none = HttpServer::Start(this->catalog, options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.GetError().message,
    this->certificate.string() + ": holds no private key in PEM without a passphrase");
}

TEST_F(Tls, SaysWhatIsWrongWithItsFiles)
{
  HttpServerOptions options;
  options.tlsCertificate = this->folder / "none.pem";
  options.tlsKey = this->key;
  const auto missing = HttpServer::Start(this->catalog, options);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.GetError().message,
    (this->folder / "none.pem").string() + ": cannot be read: No such file or directory");
  options.tlsCertificate = this->certificate;
  options.tlsKey = this->folder / "other.pem";
  EVP_PKEY* other = EVP_RSA_gen(2048);
  std::FILE* file = std::fopen(options.tlsKey.c_str(), "w");
  PEM_write_PrivateKey(file, other, nullptr, nullptr, 0, nullptr, nullptr);
  std::fclose(file);
  const auto another = HttpServer::Start(this->catalog, options);
  ASSERT_FALSE(another);
  EXPECT_EQ(another.GetError().message, options.tlsKey.string() +
                                          ": holds the key of another certificate than " +
                                          this->certificate.string());
  file = std::fopen(options.tlsKey.c_str(), "w");
  std::string word = "secret"; // which the server must not ask the terminal for
  PEM_write_PrivateKey(file, other, EVP_aes_128_cbc(),
    reinterpret_cast<unsigned char*>(word.data()), static_cast<int>(word.size()), nullptr, nullptr);
  std::fclose(file);
  EVP_PKEY_free(other);
  const auto locked = HttpServer::Start(this->catalog, options);
  ASSERT_FALSE(locked);
  EXPECT_EQ(locked.GetError().message,
    options.tlsKey.string() + ": holds no private key in PEM without a passphrase");
}
