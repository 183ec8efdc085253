// SPDX-License-Identifier: BSD-3-Clause
// A session over https: with our server, and with servers that must not be trusted.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/client/ServerClient.h"

#include "server/http/HttpServer.h"
#include "server/http/Testing/SelfSigned.h"
#include "viewer/client/Testing/SettledSession.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;
using kdstream::testing::Settle;
using kdstream::testing::TorusCatalog;

namespace
{

class TestSecureClient : public ::testing::Test
{
protected:
  void SetUp() override { WriteSelfSigned(this->Certificate, this->Key); } // for localhost

  void Start(bool secure = true)
  {
    HttpServerOptions options;
    options.drainTimeout = std::chrono::milliseconds(100);
    if (secure)
    {
      options.tlsCertificate = this->Certificate;
      options.tlsKey = this->Key;
    }
    auto server = HttpServer::Start(this->Catalog, options);
    ASSERT_TRUE(server) << server.GetError().message;
    this->Server = std::move(*server);
  }
  std::string Url(const std::string& scheme = "https://", const std::string& host = "localhost")
  {
    return scheme + host + ":" + std::to_string(this->Server->Port());
  }
  // Connects, and returns the error.
  static Error Refusal(const std::string& url, const std::string& authorities)
  {
    const auto client = ServerClient::Connect(url, "", authorities);
    EXPECT_FALSE(client) << url;
    return client ? Error{ ErrorCode::Damaged, "there is one" } : client.GetError();
  }

  const fixtures::TemporaryFolder Folder;
  const std::filesystem::path Certificate = this->Folder / "cert.pem", Key = this->Folder / "key";
  TorusCatalog Catalog;
  std::unique_ptr<HttpServer> Server;
};

TEST_F(TestSecureClient, AWholeSessionGoesOverTls)
{
  this->Start();
  auto client = ServerClient::Connect(this->Url(), "", this->Certificate.string());
  ASSERT_TRUE(client) << client.GetError().message;
  ViewerSession session;
  session.Resize({ 800, 600, 1 });
  session.SetModels((*client)->Models());
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  ASSERT_TRUE(Settle(session, **client));
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_GT(session.GetStatus().triangles, 4000u);
}

TEST_F(TestSecureClient, ACertificateThatNobodyTrustedHasSignedEndsIt)
{
  this->Start();
  const Error unknown = Refusal(this->Url(), "");
  EXPECT_EQ(unknown.code, ErrorCode::InvalidInput);
  EXPECT_NE(unknown.message.find("its certificate is not trusted: self"), std::string::npos)
    << unknown.message;
  const auto other = this->Folder / "other.pem";
  WriteSelfSigned(other, this->Folder / "other.key", "somebody else");
  EXPECT_NE(Refusal(this->Url(), other.string()).message.find("is not trusted"), std::string::npos);
}

TEST_F(TestSecureClient, ACertificateIsForItsHostAndItsTime)
{
  this->Start();
  const std::string authorities = this->Certificate.string();
  const Error host = Refusal(this->Url("https://", "127.0.0.1"), authorities);
  EXPECT_EQ(host.code, ErrorCode::InvalidInput);
  EXPECT_NE(host.message.find("not trusted: IP address mismatch"), std::string::npos)
    << host.message;
  this->Server.reset();

  WriteSelfSigned(this->Certificate, this->Key, "models.example");
  this->Start();
  const Error name = Refusal(this->Url(), authorities);
  EXPECT_NE(name.message.find("not trusted: hostname mismatch"), std::string::npos) << name.message;
  this->Server.reset();

  const auto pair = MakeKey();
  WriteKey(this->Key, pair.get());
  WriteCertificate(this->Certificate, pair.get(), "localhost", 60);
  this->Start();
  const Error old = Refusal(this->Url(), authorities);
  EXPECT_NE(old.message.find("not trusted: certificate has expired"), std::string::npos)
    << old.message;
}

TEST_F(TestSecureClient, WhoDoesNotSpeakTlsIsRecognised)
{
  this->Start(false);
  const Error plain = Refusal(this->Url(), "");
  EXPECT_EQ(plain.code, ErrorCode::InvalidInput);
  EXPECT_NE(plain.message.find("the TLS handshake failed"), std::string::npos) << plain.message;
  this->Server.reset();
  this->Start();
  const Error secure = Refusal(this->Url("http://"), "");
  EXPECT_EQ(secure.code, ErrorCode::InputOutput);
  EXPECT_NE(secure.message.find("; does it need https?"), std::string::npos) << secure.message;
}

TEST_F(TestSecureClient, AFileOfAuthoritiesHasToBeOne)
{
  this->Start();
  const auto none = this->Folder / "none.pem";
  EXPECT_EQ(Refusal(this->Url(), none.string()).code, ErrorCode::NotFound);
  std::ofstream(none) << "no certificate";
  const Error error = Refusal(this->Url(), none.string());
  EXPECT_TRUE(fixtures::IsAt(error, ErrorCode::InvalidInput, none.string()));
}

}
