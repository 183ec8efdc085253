// SPDX-License-Identifier: BSD-3-Clause
// nginx and Apache serve an exported folder by the rules in it: for each path they send the same
// headers as kdstream-serve. Skipped for a host that is not installed.
#include "Testing/Fixtures/Eventually.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/Store.h"
#include "server/app/Testing/ServeProcess.h"
#include "server/http/Testing/HttpTestClient.h"

#include <boost/asio.hpp>

#include <fstream>
#include <thread>

using namespace kdstream;

namespace
{

const std::string store = KDSTREAM_PROGRAMS "/kdstream-store";
const std::string nginx = KDSTREAM_NGINX, apache = KDSTREAM_APACHE,
                  apacheModules = KDSTREAM_APACHE_MODULES;

std::uint16_t FreePort()
{
  using boost::asio::ip::tcp;
  boost::asio::io_context context;
  return tcp::acceptor(context, { boost::asio::ip::address_v4::loopback(), 0 })
    .local_endpoint()
    .port();
}

class ExportHosts : public Serve
{
protected:
  const fs::path www = this->folder / "www";
  const std::uint16_t port = FreePort();
  std::optional<Process> host;

  void SetUp() override
  {
    Serve::SetUp();
    this->Build("ring.kds");
    const auto page = this->folder / "page";
    fs::create_directories(page);
    std::ofstream(page / "index.html") << "home";
    std::ofstream(page / "embed.js") << "script";
    std::ofstream(page / "kdstream.wasm") << "wasm";
    std::ofstream(page / "kdstream.wasm.gz") << "small";
    Process exporting({ "export", this->stores / "ring.kds", this->www, "--page", page }, store);
    ASSERT_EQ(exporting.Wait(), 0);
    fs::permissions(this->folder, fs::perms::others_read | fs::perms::others_exec,
      fs::perm_options::add); // the hosts' workers run as another user
  }
  void TearDown() override
  {
    if (this->host) // including its workers, which would outlive a kill
    {
      this->host->Signal(SIGTERM);
      EXPECT_EQ(this->host->Wait(), 0);
    }
  }
  void WaitForHost() const
  {
    EXPECT_TRUE(fixtures::Eventually([&] { return HttpTestClient::Connects(this->port); }));
  }
  void StartNginx()
  {
    const auto file = this->folder / "nginx.conf";
    std::ofstream text(file);
    text << (::geteuid() == 0 ? "user root; " : "") << "daemon off; pid "
         << (this->folder / "pid").string() << ";\nevents { }\nhttp {\naccess_log off;\n";
    for (const char* const kind : { "client_body", "proxy", "fastcgi", "uwsgi", "scgi" })
    {
      text << kind << "_temp_path " << (this->folder / kind).string() << ";\n";
    }
    text << "server { listen 127.0.0.1:" << this->port << "; root " << this->www.string()
         << "; include " << (this->www / "kdstream.nginx.conf").string() << "; }\n}\n";
    text.close();
    this->host.emplace(std::vector<std::string>{ "-c", file.string() }, nginx);
    this->WaitForHost();
  }
  void StartApache()
  {
    const auto file = this->folder / "apache.conf";
    std::ofstream text(file);
    for (const char* const module :
      { "mpm_event", "authz_core", "mime", "dir", "headers", "rewrite" })
    {
      text << "LoadModule " << module << "_module " << apacheModules << "/mod_" << module
           << ".so\n";
    }
    text << "ServerName localhost\nListen 127.0.0.1:" << this->port << "\nPidFile "
         << (this->folder / "pid").string() << "\nErrorLog " << (this->folder / "log").string()
         << "\nTypesConfig /etc/mime.types\nAddType application/x-gzip .gz\nDocumentRoot "
         << this->www.string() << "\n<Directory \"" << this->www.string()
         << "\">\nAllowOverride FileInfo\nOptions FollowSymLinks\nRequire all granted\n"
            "</Directory>\nDirectoryIndex index.html\n"
         << (::geteuid() == 0 ? "User nobody\nGroup nogroup\n" : "");
    text.close();
    this->host.emplace(
      std::vector<std::string>{ "-f", file.string(), "-DFOREGROUND", "-k", "start" }, apache);
    this->WaitForHost();
  }

  HttpTestClient::Response Get(const std::string& target, bool gzip = false) const
  {
    HttpTestClient client(this->port);
    const auto answer =
      client.Get(target, gzip ? "Accept-Encoding: gzip\r\n" : "Connection: close\r\n");
    return answer ? *answer : HttpTestClient::Response();
  }

  void CheckPage() const
  {
    const std::string policy(protocol::pagePolicy);
    const auto page = this->Get("/");
    EXPECT_EQ(page.body, "home");
    EXPECT_EQ(page.Field("Content-Security-Policy"), policy);
    EXPECT_EQ(page.Field("Referrer-Policy"), "same-origin");
    EXPECT_EQ(page.Field("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(page.Field("Cache-Control"), "no-cache");
    EXPECT_EQ(page.Field("Access-Control-Allow-Origin"), "");
    for (const char* const forOthers : { "/embed.js", "/m/ring/manifest.json" })
    {
      const auto answer = this->Get(forOthers, true);
      EXPECT_EQ(answer.status, 200u) << forOthers;
      EXPECT_EQ(answer.Field("Access-Control-Allow-Origin"), "*") << forOthers;
      EXPECT_EQ(answer.Field("Cache-Control"), "no-cache") << forOthers;
    }
    EXPECT_EQ(this->Get("/m/ring/").Field("Access-Control-Allow-Origin"), "");
    const auto wasm = this->Get("/kdstream.wasm", true);
    EXPECT_EQ(wasm.body, "small");
    EXPECT_EQ(wasm.Field("Content-Type"), "application/wasm");
    EXPECT_EQ(wasm.Field("Content-Encoding"), "gzip");
    EXPECT_EQ(wasm.Field("Content-Security-Policy"), policy);
    const auto whole = this->Get("/kdstream.wasm");
    EXPECT_EQ(whole.body, "wasm");
    EXPECT_EQ(whole.Field("Content-Type"), "application/wasm");
    EXPECT_NE(whole.Field("Vary").find("Accept-Encoding"), std::string::npos);
    for (const char* const own : { "/.htaccess", "/kdstream.nginx.conf" })
    {
      EXPECT_GE(this->Get(own).status, 403u) << own;
    }
  }
  void CheckModels() const
  {
    const auto list = this->Get("/api/models.json");
    EXPECT_EQ(list.status, 200u);
    EXPECT_EQ(list.Field("Content-Type"), "application/json");
    EXPECT_EQ(list.Field("Access-Control-Allow-Origin"), "*");
    EXPECT_EQ(list.Field("Cache-Control"), "no-cache");
    EXPECT_EQ(list.Field("X-Content-Type-Options"), "nosniff");
    const auto small = this->Get("/api/models/ring/model.json", true);
    EXPECT_EQ(small.Field("Content-Type"), "application/json");
    EXPECT_EQ(small.Field("Content-Encoding"), "gzip");
    const auto digest = (*kdstream::Store::Open(this->stores / "ring.kds"))->Info().digest;
    const auto blob =
      this->Get(protocol::BlobPath("ring", digest, protocol::BlobId::Partition(0)), true);
    EXPECT_EQ(blob.status, 200u);
    EXPECT_EQ(blob.Field("Content-Type"), "application/octet-stream");
    EXPECT_EQ(blob.Field("Cache-Control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(blob.Field("Access-Control-Allow-Origin"), "*");
    EXPECT_EQ(blob.Field("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(blob.Field("Vary"), "");
    for (const auto& folder_ : { std::string("/api"), std::string("/api/models/ring"),
           "/api/models/ring/" + digest, std::string("/api/models/none/model.json") })
    {
      EXPECT_EQ(this->Get(folder_).status, 404u) << folder_;
    }
  }
};

}

TEST_F(ExportHosts, Nginx)
{
  if (nginx.empty())
  {
    GTEST_SKIP() << "nginx is not installed";
  }
  this->StartNginx();
  this->CheckPage();
  this->CheckModels();
  const auto list = this->Get("/api/models");
  EXPECT_EQ(list.body, this->Get("/api/models.json").body) << "its other name";
  EXPECT_EQ(list.Field("Content-Type"), "application/json");
}

TEST_F(ExportHosts, Apache)
{
  if (apache.empty())
  {
    GTEST_SKIP() << "Apache is not installed";
  }
  this->StartApache();
  this->CheckPage();
  this->CheckModels();
  const auto list = this->Get("/api/models"); // Apache serves no file for this folder
  EXPECT_EQ(list.status, 302u);
  EXPECT_EQ(list.Field("Location"), "http://test/api/models.json");
}
