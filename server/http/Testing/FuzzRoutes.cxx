// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the code above Beast. The bytes of a connection become requests, which are
// answered as in a server, once without and once with tokens, from real stores and files. Input
// that begins with "PROXY", or with the signature of version 2, first goes through the reader of a
// proxy's header. DIGEST is replaced by the digest of the model tetrahedron, and VERSION by the
// version of its tileset, so that the model's blobs and tiles are found.
//
// For any input an answer is valid HTTP: it lies within its source, no field breaks its line, an
// answer given at once equals the one given later, and without a token nothing of a model is sent.
#include "server/access/Testing/ForgedToken.h"
#include "server/http/ClientLimits.h"
#include "server/http/HttpMessage.h"
#include "server/http/ProxyHeader.h"
#include "server/http/RequestInput.h"
#include "server/http/Routes.h"
#include "server/http/Testing/WholeAnswer.h"
#include "server/session/StoreCatalog.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include <unistd.h>

using namespace kdstream;

namespace
{

void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::fprintf(stderr, "FuzzRoutes: %s\n", what);
    std::abort();
  }
}

class Site
{
public:
  Site()
    : Web(std::filesystem::temp_directory_path() / ("kdstream-fuzz-" + std::to_string(::getpid())))
    , Catalog(KDSTREAM_SMALL_STORES, [](const auto&, const auto&) {})
  {
    std::filesystem::create_directories(this->Web / "folder");
    std::ofstream(this->Web / "index.html") << "<!DOCTYPE html>";
    std::ofstream(this->Web / "index.html.gz") << "gz";
    std::ofstream(this->Web / "folder" / "app.js") << "let a = 1;";
    Require(this->Catalog.Reload().HasValue() && !this->Catalog.Models().empty(), "no stores");
    RouteOptions open;
    open.web = *StaticFiles::Open(this->Web);
    open.allowOrigin = "*";
    open.version = "1";
    this->Open = std::make_unique<Routes>(this->Catalog, this->Counters, open);
    RouteOptions guarded;
    guarded.guard =
      std::make_shared<const TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; });
    guarded.allowOrigin = "https://a.example";
    this->Guarded = std::make_unique<Routes>(this->Catalog, this->Counters, guarded);
  }
  ~Site() { std::filesystem::remove_all(this->Web); }

  std::filesystem::path Web;
  StoreCatalog Catalog;
  Metrics Counters;
  std::unique_ptr<Routes> Open, Guarded;
  TrustedProxies Proxies = *TrustedProxies::Parse({ "10.0.0.0/8", "::1" });
};

Site& TheSite()
{
  static Site site;
  return site;
}

bool BreaksLines(std::string_view text)
{
  return text.find_first_of(std::string_view("\r\n\0", 3)) != std::string_view::npos;
}

void LookAt(const HttpRequest& request, const HttpResponse& response)
{
  static const std::set<unsigned> known{ 200, 204, 206, 304, 400, 401, 403, 404, 405, 410, 416, 426,
    500, 501, 503 };
  Require(known.count(response.status) != 0, "no status of ours");
  Require(response.status < 500 || response.status == 501 || request.target.find("/readyz") == 0,
    "a failure of the server");
  const bool hasBody = response.body && !response.omitBody;
  Require(!hasBody || (response.begin <= response.body->size() &&
                        response.length <= response.body->size() - response.begin),
    "a body beyond what it is from");
  Require(hasBody || response.omitBody || response.length == 0, "a length without a body");
  Require(
    response.status != 206 || (!response.Field("Content-Range").empty() && response.length > 0),
    "a part that does not say which");
  Require((response.status != 304 && response.status != 204 && response.status != 416) ||
            response.length == 0,
    "a body where none may be");
  for (const auto& [name, value] : response.fields)
  {
    Require(
      !name.empty() && !BreaksLines(name) && !BreaksLines(value), "a field that breaks its line");
  }
  const auto head = WriteResponseHead(response, false, true, std::chrono::seconds(1));
  namespace http = boost::beast::http;
  http::response_parser<http::empty_body> parser;
  parser.skip(true);
  boost::beast::error_code error;
  const auto taken = parser.put(boost::asio::buffer(head), error);
  Require(!error && taken == head.size() && parser.is_header_done(), "a head that is not HTTP");
}

void Ask(const Routes& routes, const HttpRequest& request)
{
  const auto found = routes.Find(request);
  if (const auto* const atOnce = std::get_if<HttpResponse>(&found))
  {
    LookAt(request, *atOnce);
  }
  else
  {
    const auto& reading = std::get<Routes::Reading>(found);
    const auto answer = reading.Answer();
    LookAt(request, answer);
    const auto uncounted = reading.Uncounted();
    Require(
      reading.counts != Routes::Counts::Yes || !uncounted, "counts, and is given for nothing");
    Require(
      !uncounted || (uncounted->status == answer.status && uncounted->fields == answer.fields),
      "another answer where it does not count");
  }
  LookAt(request, routes.AnswerAdmin(request));
}

void Answer(const ParsedRequest& parsed)
{
  auto& site = TheSite();
  auto request = PlainRequest(parsed, "192.0.2.1");
  request.client = site.Proxies.ClientOf("10.1.2.3", JoinedFields(parsed, "X-Forwarded-For"));
  Require(request.client.size() < 64, "no address");
  Ask(*site.Open, request);
  Ask(*site.Guarded, request);
  const auto guarded = kdstream::Answer(*site.Guarded, request);
  const bool isRead = request.method == "GET" || request.method == "HEAD";
  Require(!isRead || request.target.substr(0, 8) != "/api/mod" || guarded.status == 401 ||
            guarded.status == 400 || guarded.status == 404,
    "told without a token");
  const auto text = [&](boost::beast::http::field name)
  {
    const auto value = parsed[name];
    return std::string(value.data(), value.size());
  };
  if (boost::beast::websocket::is_upgrade(parsed))
  {
    namespace http = boost::beast::http;
    (void)http::token_list(text(http::field::sec_websocket_protocol)).exists("kdstream.v2");
    (void)site.Guarded->MayStream(text(http::field::origin), text(http::field::host));
    Require(!site.Guarded
               ->Admit(request.client, text(http::field::authorization),
                 JoinedFields(parsed, "Sec-WebSocket-Protocol"))
               .HasValue(),
      "admitted without a token");
  }
}

void ReplaceAll(std::string& text, std::string_view name, const std::string& by)
{
  for (auto at = text.find(name); at != std::string::npos; at = text.find(name, at))
  {
    text.replace(at, name.size(), by);
  }
}

// The version of the tetrahedron's tileset, which is part of the addresses of its tiles.
std::string VersionOfTileset()
{
  const auto root = kdstream::Answer(
    *TheSite().Open, { "GET", "/api/models/tetrahedron/3dtiles/tileset.json", "", "", "" });
  Require(root.status == 200 && root.body, "no tileset");
  const std::string text(root.body->begin(), root.body->end());
  const auto at = text.find("\"uri\":\"");
  Require(at != std::string::npos, "a tileset without tiles");
  return text.substr(at + 7, 32);
}

std::string WithDigest(std::string_view bytes)
{
  static const std::string digest = TheSite().Catalog.Find("tetrahedron")->Description().digest;
  static const std::string version = VersionOfTileset();
  std::string text(bytes);
  ReplaceAll(text, "DIGEST", digest);
  ReplaceAll(text, "VERSION", version);
  return text;
}

// The length of the header in bytes; 0 if it has no end, or is not a header.
std::size_t TakeProxyHeader(std::string_view bytes)
{
  ProxyHeader header;
  std::size_t taken = 0;
  for (auto space = header.Space(); !space.empty(); space = header.Space())
  {
    if (space.size() > bytes.size() - taken)
    {
      return bytes.size();
    }
    std::memcpy(space.data(), bytes.data() + taken, space.size());
    taken += space.size();
    header.Take();
    Require(taken <= ProxyHeader::mostBytes, "a header without an end");
  }
  Require(header.IsMalformed() || header.Client().size() < 64, "no address");
  return taken;
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string text = WithDigest({ reinterpret_cast<const char*>(data), size });
  std::string_view bytes = text;
  if (bytes.starts_with("PROXY ") || bytes.starts_with("\r\n\r\n"))
  {
    bytes.remove_prefix(TakeProxyHeader(bytes));
  }
  RequestInput input(8192);
  for (int requests = 0; requests < 8; ++requests)
  {
    input.Begin();
    auto ended = input.Parse();
    while (!ended && !bytes.empty())
    {
      const auto taken = boost::asio::buffer_copy(input.Prepare(),
        boost::asio::buffer(bytes.data(), std::min<std::size_t>(bytes.size(), 100)));
      input.Commit(taken);
      bytes.remove_prefix(taken);
      ended = input.Parse();
    }
    if (!ended || *ended)
    {
      break;
    }
    Answer(input.Request());
  }
  return 0;
}
