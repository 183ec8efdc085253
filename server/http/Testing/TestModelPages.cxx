// SPDX-License-Identifier: BSD-3-Clause
// Pages of models as a server answers them: heads, refusals, pictures, oEmbed, caching, and which
// address the pages name.
#include "server/access/Testing/ForgedToken.h"
#include "server/http/Routes.h"

#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Notes.h"
#include "filters/protocol/ResourcePath.h"
#include "server/http/Testing/ServerTest.h"
#include "server/http/Testing/WholeAnswer.h"
#include "server/session/StoreCatalog.h"

#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

using namespace kdstream;

namespace
{

constexpr const char* pageOfTest = "<html><head><title>KdStream</title></head><body><main></main>"
                                   "<script src=\"page.js\"></script></body></html>";

std::string TextOf(const HttpResponse& response)
{
  return response.body ? std::string(response.body->begin(), response.body->end()) : "";
}

bool Holds(const std::string& text, const std::string& part)
{
  return text.find(part) != text.npos;
}

class ModelPages : public testing::Test
{
protected:
  fixtures::TemporaryFolder folder;
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 4, 3000);
  Metrics metrics;
  std::string root = "https://museum.example/";

  void SetUp() override
  {
    std::ofstream(this->folder / "index.html") << pageOfTest;
    this->catalog.SetSite({ "A museum", "" });
    this->catalog.SetPages("m/");
    this->model->Retell().title = "A <b>dragon</b>";
  }
  RouteOptions Options(bool isGuarded = false) const
  {
    RouteOptions options;
    options.web = *StaticFiles::Open(this->folder / "");
    options.contact = "Ask <Ann>.";
    if (isGuarded)
    {
      options.guard =
        std::make_shared<const TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; });
    }
    return options;
  }
  HttpResponse Get(const std::string& target, bool isGuarded = false, const std::string& token = {},
    const std::string& tag = {}, const std::string& encoding = {}) const
  {
    const Routes routes(
      this->catalog, const_cast<Metrics&>(this->metrics), this->Options(isGuarded));
    HttpRequest request{ "GET", target, tag, "", "" };
    request.authorization = token.empty() ? "" : "Bearer " + token;
    request.acceptEncoding = encoding;
    request.root = this->root;
    return Answer(routes, request);
  }
};

}

TEST_F(ModelPages, EachModelHasAPage)
{
  for (const char* const target : { "/m/dragon", "/m/dragon?embed", "/m/dr%61gon" })
  {
    const auto response = this->Get(target);
    ASSERT_EQ(response.status, 200u) << target;
    const auto page = TextOf(response);
    EXPECT_TRUE(Holds(page, "<title>A &lt;b&gt;dragon&lt;/b&gt; – A museum</title>")) << page;
    EXPECT_TRUE(Holds(page, "<link rel=\"canonical\" href=\"https://museum.example/m/dragon\">"));
    EXPECT_TRUE(Holds(page, "src=\"../page.js\""));
    EXPECT_EQ(response.Field("Content-Type"), "text/html; charset=utf-8");
    EXPECT_EQ(response.Field("Cache-Control"), "no-cache");
    EXPECT_EQ(response.Field("Vary"), "Accept-Encoding");
    EXPECT_EQ(response.Field("Content-Security-Policy"), protocol::pagePolicy);
    EXPECT_EQ(response.Field("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(this->Get(target, false, "", std::string(response.Field("ETag"))).status, 304u);
    const auto small = this->Get(target, false, "", "", "gzip");
    EXPECT_EQ(small.Field("Content-Encoding"), "gzip");
    EXPECT_LT(small.length, response.length);
    EXPECT_NE(small.Field("ETag"), response.Field("ETag"));
  }
  EXPECT_TRUE(Holds(TextOf(this->Get("/m/dragon/")), "src=\"../../page.js\""));
  EXPECT_EQ(this->Get("/m/dragon/nothing").status, 404u);
  const auto list = TextOf(this->Get("/api/models.json"));
  EXPECT_EQ(nlohmann::json::parse(list)["pages"], "m/");
  EXPECT_EQ(ParseModelList(list)->size(), 1u);
  this->root.clear();
  EXPECT_TRUE(
    Holds(TextOf(this->Get("/m/dragon")), "<link rel=\"canonical\" href=\"../m/dragon\">"));
}

// Without scripts the page has a link to each model.
TEST_F(ModelPages, AllModelsHaveAPage)
{
  const auto response = this->Get("/m/");
  EXPECT_EQ(response.status, 200u);
  const auto page = TextOf(response);
  EXPECT_TRUE(Holds(page, "<a href=\"../m/dragon\">A &lt;b&gt;dragon&lt;/b&gt;</a>")) << page;
  EXPECT_TRUE(Holds(page, "<link rel=\"canonical\" href=\"https://museum.example/m/\">"));
  EXPECT_TRUE(Holds(page, "src=\"../page.js\""));
  EXPECT_EQ(response.Field("Content-Security-Policy"), protocol::pagePolicy);
  const auto above = TextOf(this->Get("/m"));
  EXPECT_TRUE(Holds(above, "<a href=\"m/dragon\">")) << above;
  EXPECT_TRUE(Holds(above, "src=\"page.js\""));
  EXPECT_EQ(this->Get("/m/", true).status, 401u);
  EXPECT_FALSE(Holds(TextOf(this->Get("/m/", true)), "dragon"));
  const auto of = [](const std::string& models)
  {
    return forged::Token(forged::header,
      R"({"sub":"ann","exp":2000,"models":[")" + models + R"("],"detail":"preview"})");
  };
  EXPECT_TRUE(Holds(TextOf(this->Get("/m/", true, of("dragon"))), "m/dragon"));
  EXPECT_FALSE(Holds(TextOf(this->Get("/m/", true, of("vase"))), "dragon"));
}

TEST_F(ModelPages, SearchEnginesFindAllPages)
{
  const auto robots = this->Get("/robots.txt");
  EXPECT_EQ(robots.Field("Content-Type"), "text/plain; charset=utf-8");
  EXPECT_TRUE(Holds(TextOf(robots), "\nSitemap: https://museum.example/sitemap.xml\n"));
  const auto map = this->Get("/sitemap.xml");
  EXPECT_EQ(map.Field("Content-Type"), "application/xml");
  EXPECT_TRUE(Holds(TextOf(map), "<url><loc>https://museum.example/m/dragon</loc></url>"))
    << TextOf(map);
  EXPECT_EQ(this->Get("/sitemap.xml", true).status, 404u) << "with tokens";
  std::ofstream(this->folder / "robots.txt") << "own";
  EXPECT_EQ(TextOf(this->Get("/robots.txt")), "own");
  this->root.clear();
  EXPECT_EQ(this->Get("/sitemap.xml").status, 404u) << "it needs whole addresses";
}

TEST_F(ModelPages, AModelThatIsGoneSaysSo)
{
  for (const char* const target :
    { "/m/lucy", "/m/..", "/m/.x", "/m/a%2fb", "/m/%3Cscript%3E", "/m/%zz", "/m/a%00b", "/m/a%ff" })
  {
    const auto response = this->Get(target);
    EXPECT_EQ(response.status, 404u) << target;
    const auto page = TextOf(response);
    EXPECT_TRUE(Holds(page, "<h1 dir=\"auto\">There is no such model</h1>")) << page;
    EXPECT_TRUE(Holds(page, "noindex"));
    EXPECT_TRUE(Holds(page, "src=\"../page.js\"")) << "the viewer shows the others";
    EXPECT_FALSE(Holds(page, "<script>")) << page;
    EXPECT_EQ(response.Field("Cache-Control"), "no-store");
    EXPECT_EQ(response.Field("Content-Type"), "text/html; charset=utf-8");
  }
  EXPECT_EQ(this->Get("/m/lucy/picture.jpg").status, 404u);
  EXPECT_EQ(this->Get("/m/lucy/manifest.json").status, 404u);
  EXPECT_LT(this->Get("/m/" + std::string(7000, 'a')).length, 2000u);
}

TEST_F(ModelPages, WithoutATokenNothingIsRevealedOfAModel)
{
  const auto token = [](const std::string& models)
  {
    return forged::Token(forged::header,
      R"({"sub":"ann","exp":2000,"models":[")" + models + R"("],"detail":"preview"})");
  };
  std::string refused;
  for (const auto& [target, bearer] : { std::pair{ "/m/dragon", std::string() }, { "/m/lucy", "" },
         { "/m/dragon", "x.y.z" }, { "/m/dragon", token("vase") }, { "/m/lucy", token("vase") } })
  {
    const auto response = this->Get(target, true, bearer);
    EXPECT_EQ(response.status, 401u) << target << bearer;
    EXPECT_EQ(response.Field("WWW-Authenticate"), "Bearer");
    EXPECT_EQ(response.Field("Cache-Control"), "no-store");
    const auto page = TextOf(response);
    EXPECT_TRUE(Holds(page, "<h1 dir=\"auto\">A token is needed</h1>")) << page;
    EXPECT_TRUE(Holds(page, "Ask &lt;Ann&gt;.")) << page;
    EXPECT_FALSE(Holds(page, "&lt;b&gt;")) << "its title: " << page;
    EXPECT_TRUE(Holds(page, "src=\"../page.js\"")) << "the viewer asks for one";
  }
  const std::string embed = "/oembed?url=https%3A%2F%2Fmuseum.example%2Fm%2Fdragon";
  for (const std::string& target : { std::string("/m/dragon/picture.jpg"),
         "/api/models/dragon/" + this->model->Description().digest + "/preview.glb",
         std::string("/m/dragon/manifest.json"), embed })
  {
    EXPECT_EQ(this->Get(target, true).status, 401u) << target;
    EXPECT_EQ(this->Get(target, true, token("vase")).status, 403u) << target;
  }
  EXPECT_EQ(this->Get("/m/lucy", true, token("lucy")).status, 404u);
  const auto allowed = this->Get("/m/dragon", true, token("dragon"));
  EXPECT_EQ(allowed.status, 200u);
  EXPECT_TRUE(Holds(TextOf(allowed), "dragon&lt;/b&gt;"));
  EXPECT_EQ(allowed.Field("Cache-Control"), "private, no-cache");
  EXPECT_EQ(allowed.Field("Vary"), "Accept-Encoding, Authorization");
  EXPECT_EQ(this->Get("/m/dragon/manifest.json", true, token("dragon")).Field("Cache-Control"),
    "private, no-cache");
}

TEST_F(ModelPages, TheyCanBeEmbedded)
{
  const std::string url = "/oembed?url=https%3A%2F%2Fmuseum.example%2Fm%2Fdragon";
  const auto response = this->Get(url + "&maxwidth=300&maxheight=200");
  ASSERT_EQ(response.status, 200u);
  EXPECT_EQ(response.Field("Content-Type"), "application/json");
  const auto json = nlohmann::json::parse(TextOf(response));
  EXPECT_EQ(json["width"], 300);
  EXPECT_EQ(json["height"], 200);
  EXPECT_EQ(json["provider_name"], "A museum");
  EXPECT_EQ(
    this->Get("/oembed?url=https%3A%2F%2Fmuseum.example%2F%23model%3Ddragon%26view%3DA").status,
    200u)
    << "an old address";
  EXPECT_EQ(this->Get(url + "&format=xml").status, 501u);
  EXPECT_EQ(this->Get(url + "&maxwidth=wide").status, 400u);
  for (const char* const wrong :
    { "/oembed", "/oembed?url=", "/oembed?url=https%3A%2F%2Fother.example%2Fm%2Fdragon",
      "/oembed?url=https%3A%2F%2Fmuseum.example%2Fm%2Flucy" })
  {
    EXPECT_EQ(this->Get(wrong).status, 404u) << wrong;
  }
  this->root.clear();
  EXPECT_EQ(this->Get(url).status, 404u) << "it does not know where it is";
}

TEST_F(ModelPages, TheManifestHasTheNotesAsTheyAreNow)
{
  const auto manifest = [this]
  { return nlohmann::json::parse(TextOf(this->Get("/m/dragon/manifest.json"))); };
  EXPECT_EQ(manifest()["id"], "https://museum.example/m/dragon/manifest.json");
  EXPECT_FALSE(manifest()["items"][0].contains("annotations"));
  const auto put = [this](const std::string& text)
  {
    this->catalog.notes.insert_or_assign(
      "dragon", std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end()));
  };
  put(FormatNotes({ { "The crack", "It is old.", "model=dragon&view=AX9" } }));
  EXPECT_EQ(manifest()["items"][0]["annotations"][0]["items"][0]["body"]["value"], "It is old.");
  put("{");
  EXPECT_FALSE(manifest()["items"][0].contains("annotations"));
}

TEST_F(ModelPages, APreviewThatIsDamagedHasNoPicture)
{
  EXPECT_EQ(this->Get("/m/dragon/picture.jpg").status, 500u) << "made up in memory, it is no piece";
  EXPECT_FALSE(Holds(TextOf(this->Get("/m/dragon/picture.jpg")), "secret"));
  this->model->fails = ErrorCode::InputOutput;
  EXPECT_EQ(this->Get("/m/dragon/picture.jpg").status, 503u);
}

TEST_F(ModelPages, APictureIsDrawnOnce)
{
  BuildOptions options;
  const auto stores = this->folder / "stores";
  std::filesystem::create_directories(stores);
  ASSERT_TRUE(BuildStore(fixtures::Torus(60, 30), "torus.ply", stores / "torus.kds", options));
  StoreCatalog kept(stores, [](const std::filesystem::path&, const std::string&) {});
  ASSERT_TRUE(kept.Reload());
  const Routes routes(kept, this->metrics, this->Options());
  const HttpRequest request{ "GET", "/m/torus/picture.jpg", "", "", "" };
  EXPECT_TRUE(std::holds_alternative<Routes::Reading>(routes.Find(request))) << "it takes time";
  const auto first = Answer(routes, request);
  ASSERT_EQ(first.status, 200u) << TextOf(first);
  EXPECT_EQ(first.Field("Content-Type"), "image/jpeg");
  EXPECT_EQ(first.Field("Cache-Control"), "no-cache");
  EXPECT_EQ(TextOf(first).substr(0, 3), "\xff\xd8\xff");
  EXPECT_EQ(Answer(routes, request).body, first.body) << "the very same";
  auto again = request;
  again.ifNoneMatch = first.Field("ETag");
  EXPECT_EQ(Answer(routes, again).status, 304u);
  EXPECT_TRUE(
    Holds(TextOf(Answer(routes, { "GET", "/m/torus", "", "", "" })), "summary_large_image"));
  const std::string begin = "/api/models/torus/";
  const auto digest = kept.Find("torus")->Description().digest;
  const auto preview = Answer(routes, { "GET", begin + digest + "/preview.glb", "", "", "" });
  ASSERT_EQ(preview.status, 200u) << TextOf(preview);
  EXPECT_EQ(TextOf(preview).substr(0, 4), "glTF");
  EXPECT_EQ(preview.Field("Content-Type"), "model/gltf-binary");
  const auto statusOf = [&routes](const std::string& target) {
    return Answer(routes, { "GET", target, "", "", "" }).status;
  };
  EXPECT_EQ(statusOf(begin + std::string(32, 'a') + "/preview.glb"), 410u);
  EXPECT_EQ(statusOf(begin + "preview.glb"), 404u);
  EXPECT_EQ(statusOf("/api/models/lucy/" + digest + "/preview.glb"), 404u);
}

TEST_F(ModelPages, WithoutAViewerThereAreNone)
{
  const Routes routes(this->catalog, this->metrics, {});
  EXPECT_EQ(Answer(routes, { "GET", "/m/dragon", "", "", "" }).status, 404u);
}

namespace
{

class PageServer : public ServerTest
{
protected:
  fixtures::TemporaryFolder folder;
  void SetUp() override
  {
    std::ofstream(this->folder / "index.html") << pageOfTest;
    this->options.web = *StaticFiles::Open(this->folder / "");
  }
  void TearDown() override { this->server.reset(); }
  // The address that the page names as its own, if a request has these fields.
  std::string Canonical(std::uint16_t port, const std::string& host, const std::string& fields = "")
  {
    HttpTestClient client(port);
    client.Send("GET /m/dragon HTTP/1.1\r\nHost: " + host + "\r\n" + fields + "\r\n");
    const auto response = client.Receive();
    const std::string page = response ? response->body : "";
    const std::string begin = "rel=\"canonical\" href=\"";
    const auto at = page.find(begin);
    return at == page.npos ? page
                           : page.substr(at + begin.size(),
                               page.find('"', at + begin.size()) - at - begin.size());
  }
};

}

TEST_F(PageServer, OnlyAListedHostIsTakenForTheAddress)
{
  const auto port = this->Start();
  EXPECT_EQ(this->Canonical(port, "localhost:1"), "../m/dragon") << "nobody has said that it is so";
  EXPECT_EQ(
    this->Canonical(port, "127.0.0.1", "X-Forwarded-Host: evil.example\r\n"), "../m/dragon");
  this->options.allowedHosts = { "museum.example" };
  const auto listed = this->Start();
  EXPECT_EQ(this->Canonical(listed, "museum.example:8700"), "http://museum.example:8700/m/dragon");
  EXPECT_EQ(this->Canonical(listed, "museum.example", "X-Forwarded-Proto: https\r\n"),
    "http://museum.example/m/dragon")
    << "not a trusted proxy";
  EXPECT_NE(this->Canonical(listed, "evil.example").find("error"), std::string::npos) << "421";
  this->options.trustedProxies = { "127.0.0.1" };
  const auto proxied = this->Start();
  EXPECT_EQ(this->Canonical(proxied, "museum.example", "X-Forwarded-Proto: https\r\n"),
    "https://museum.example/m/dragon");
  EXPECT_EQ(this->Canonical(proxied, "museum.example",
              "X-Forwarded-Host: evil.example\r\nX-Forwarded-Proto: \"><script>\r\n"),
    "http://museum.example/m/dragon");
  this->options.publicAddress = "https://public.example/3d/";
  const auto reported = this->Start();
  EXPECT_EQ(this->Canonical(reported, "museum.example"), "https://public.example/3d/m/dragon");
}
