// SPDX-License-Identifier: BSD-3-Clause
// Heads, embedding and manifests of models with arbitrary texts.
#include "filters/page/ModelPage.h"

#include "filters/model/JsonWriter.h"
#include "filters/page/EmbedAnswer.h"
#include "filters/page/IiifManifest.h"

#include <gtest/gtest.h>

#include <tuple>

#include <nlohmann/json.hpp>

using namespace kdstream;
using Json = nlohmann::json;

namespace
{

const std::string viewerPage =
  "<!doctype html>\n<html lang=\"en\">\n<head>\n<title>KdStream</title>\n"
  "<link rel=\"icon\" href=\"icon.svg\">\n<link rel=\"stylesheet\" href=\"style.css\">\n"
  "<script type=\"module\" src=\"page.js\"></script>\n</head>\n<body data-mode=\"no model\">\n"
  "<main></main>\n<noscript><p id=\"no-script\">Off.</p></noscript>\n"
  "<a href=\"#top\"></a><img src=\"data:image/png;base64,AA\"><img "
  "src=\"/a.png\">\n</body>\n</html>\n";

const std::vector<std::string> hostileTexts{ "</title><script>alert(1)</script>",
  "\"><img src=x onerror=alert(1)>", "' onload='alert(1)", "</script><!-- <noscript>", "<title>",
  "</noscript>", "&lt;b&gt; & &amp;", std::string("a\0b\x01\x7f", 5), "\xff\xfe<", "</head><body>",
  "مزهرية <b>زرقاء</b>", "javascript:alert(1)", "https://a.example/\"><script>", "${x} $& $1" };

ModelDescription Reported()
{
  ModelDescription model;
  model.id = "dragon";
  model.digest = "0123456789abcdef0123456789abcdef";
  model.title = "A dragon";
  model.credit = "Stanford University";
  model.license = "https://creativecommons.org/licenses/by/4.0/";
  model.description = "Of porcelain.";
  model.unit = "mm";
  model.triangles = 871414;
  model.vertices = 437645;
  model.box.Add(Vec3{ 0, 0, 0 });
  model.box.Add(Vec3{ 205.25, 144.5, 9.04 });
  model.levels.resize(1);
  model.levels[0].bytes = 1000;
  return model;
}

std::size_t Count(const std::string& text, const std::string& part)
{
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1))
  {
    ++count;
  }
  return count;
}

bool Has(const std::string& text, const std::string& part)
{
  return text.find(part) != text.npos;
}

// The content of the only <script …json>.
Json DataOf(const std::string& page)
{
  const std::string begin = "<script type=\"application/ld+json\">";
  EXPECT_EQ(Count(page, begin), 1u);
  const auto at = page.find(begin) + begin.size();
  return Json::parse(page.substr(at, page.find("</script>", at) - at));
}

// Removes this content. In it only "<" and ">" could be more than text, so it must not contain
// them.
std::string WithoutData(std::string page)
{
  const auto begin = page.find("{\"@context\"");
  const auto end = page.find("</script>", begin);
  EXPECT_EQ(page.substr(begin, end - begin).find_first_of("<>"), page.npos) << page;
  return page.erase(begin, end - begin);
}

const PagePlace known{ "https://museum.example/3d/" };

}

TEST(ModelPage, TheHeadIsTheModels)
{
  const auto page = MakeModelPage(viewerPage, Reported(), known, "A museum");
  for (const std::string part :
    { "<title>A dragon – A museum</title>",
      "<meta name=\"description\" content=\"Of porcelain. Stanford University. 205 × 145 × 9 mm\">",
      "<link rel=\"canonical\" href=\"https://museum.example/3d/m/dragon\">",
      "<meta property=\"og:title\" content=\"A dragon\">",
      "<meta property=\"og:site_name\" content=\"A museum\">",
      "<meta property=\"og:url\" content=\"https://museum.example/3d/m/dragon\">",
      "<meta property=\"og:image\" content=\"https://museum.example/3d/m/dragon/picture.jpg\">",
      "<meta property=\"og:image:width\" content=\"1200\">",
      "<meta name=\"twitter:card\" content=\"summary_large_image\">",
      "<link rel=\"alternate\" type=\"application/json+oembed\" "
      "href=\"https://museum.example/3d/"
      "oembed?url=https%3A%2F%2Fmuseum.example%2F3d%2Fm%2Fdragon\" title=\"A dragon\">",
      "href=\"https://museum.example/3d/m/dragon/manifest.json\"", "href=\"../style.css\"",
      "href=\"../icon.svg\"", "src=\"../page.js\"", "src=\"/a.png\"", "href=\"#top\"",
      "src=\"data:", "<h1 dir=\"auto\">A dragon</h1>", "src=\"../m/dragon/picture.jpg\"",
      "871,414 triangles</p>", "<a href=\"../m/\">All models</a>" })
  {
    EXPECT_TRUE(Has(page, part)) << part << "\n" << page;
  }
  EXPECT_FALSE(Has(page, "<title>KdStream")) << "one title";
  EXPECT_EQ(Count(page, "<noscript>"), 1u);
  const auto data = DataOf(page);
  EXPECT_EQ(data["@type"], "3DModel");
  EXPECT_EQ(data["name"], "A dragon");
  EXPECT_EQ(data["license"], Reported().license);
  EXPECT_EQ(data["image"], "https://museum.example/3d/m/dragon/picture.jpg");
  EXPECT_EQ(data["isPartOf"]["name"], "A museum");
  EXPECT_EQ(data["encoding"]["encodingFormat"], "model/gltf-binary");
}

TEST(ModelPage, WhereTheAddressIsNotKnownItIsRelative)
{
  const auto page = MakeModelPage(viewerPage, Reported(), { {}, "../../" }, "");
  EXPECT_TRUE(Has(page, "<link rel=\"canonical\" href=\"../../m/dragon\">")) << page;
  EXPECT_TRUE(Has(page, "src=\"../../page.js\""));
  EXPECT_FALSE(Has(page, "oembed")) << "it needs whole addresses";
  EXPECT_FALSE(Has(page, "content=\"http")) << page;
  const auto folder =
    MakeModelPage(viewerPage, Reported(), { "https://a.example/", "../../", true }, "");
  EXPECT_TRUE(Has(folder, "href=\"https://a.example/m/dragon/\"")) << folder;
  EXPECT_TRUE(Has(folder, "href=\"https://a.example/m/dragon/oembed.json\""));
}

TEST(ModelPage, AModelThatSaysNothingHasItsIdAndNoPicture)
{
  ModelDescription model;
  model.id = "a.b_c";
  model.primitive = PrimitiveType::Points;
  model.vertices = 1234;
  const auto page = MakeModelPage(viewerPage, model, known, "");
  EXPECT_TRUE(Has(page, "<title>a.b_c – KdStream</title>")) << page;
  EXPECT_TRUE(Has(page, "content=\"1,234 points\""));
  EXPECT_TRUE(Has(page, "content=\"summary\""));
  EXPECT_FALSE(Has(page, "picture.jpg"));
  EXPECT_FALSE(Has(page, "content=\"\""));
}

// With hostile texts the page must have the same number of tags of each kind as with harmless ones.
TEST(ModelPage, HostileTextsStayTexts)
{
  const auto usual = MakeModelPage(viewerPage, Reported(), known, "A museum");
  for (const std::string& text : hostileTexts)
  {
    auto model = Reported();
    model.title = model.credit = model.description = model.unit = text;
    const auto page = MakeModelPage(viewerPage, model, known, text);
    for (const char* const tag : { "<", ">", "\"", "'", "<script", "</script", "<title", "</title",
           "<noscript", "</noscript", "<img", "<body", "</head" })
    {
      EXPECT_EQ(Count(WithoutData(page), tag), Count(WithoutData(usual), tag))
        << tag << " of " << text << "\n"
        << page;
    }
    EXPECT_EQ(page.find('\0'), page.npos);
    EXPECT_EQ(DataOf(page)["name"], Json::parse(JsonWriter().Put(TextsOf(model).title).Text()));
    model.license = text;
    const auto licensed = MakeModelPage(viewerPage, model, known, text);
    EXPECT_EQ(Count(licensed, "<script"), Count(usual, "<script")) << licensed;
    EXPECT_FALSE(Has(licensed, "href=\"javascript:")) << licensed;
    const auto refused = MakeRefusalPage(viewerPage, "No model", text, known, text);
    EXPECT_EQ(Count(refused, "<script"), 1u) << refused;
    EXPECT_EQ(Count(refused, "<title>"), 1u) << refused;
  }
}

TEST(ModelPage, LongTextsAreCutBetweenCharacters)
{
  auto model = Reported();
  model.description.clear();
  for (int i = 0; i < 2000; ++i)
  {
    model.description += "ä";
  }
  const auto texts = TextsOf(model);
  EXPECT_LT(texts.summary.size(), 600u);
  EXPECT_TRUE(texts.summary.ends_with("ä… Stanford University. 205 × 145 × 9 mm")) << texts.summary;
}

// A title must not reverse the site's name or a number that follows it.
TEST(ModelPage, NoTextTurnsRoundWhatFollowsIt)
{
  auto model = Reported();
  model.title = "\u202eevil\u2066 title";
  model.credit = "Ann \u202d\u2067 Co\u2069\u202c";
  model.description = "مزهرية\u200f \u202b1";
  const auto texts = TextsOf(model);
  EXPECT_EQ(texts.title, "evil title");
  EXPECT_EQ(texts.summary, "مزهرية\u200f 1. Ann  Co. 205 × 145 × 9 mm") << "marks stay";
  const auto page = MakeModelPage(viewerPage, model, known, "A museum");
  EXPECT_TRUE(Has(page, "<title>evil title – A museum</title>")) << page;
  const auto embed = Json::parse(WriteEmbedAnswer(model, known, ""));
  EXPECT_EQ(embed["title"], "evil title");
  EXPECT_EQ(embed["author_name"], "Ann  Co");
  model.title = "\u202e \u2069";
  EXPECT_EQ(TextsOf(model).title, "dragon") << "nothing is left of it";
}

TEST(ModelPage, SizesAreInAUnitThatOneReads)
{
  for (const auto& [longest, unit, size] : { std::tuple{ 0.206, "m", "20.6 × 10.3 × 0 cm" },
         { 206.0, "mm", "206 × 103 × 0 mm" }, { 1234.0, "mm", "1.23 × 0.62 × 0 m" },
         { 3.2e-5, "metres", "32 × 16 × 0 µm" }, { 0.5, "feet", "0.5 × 0.25 × 0 feet" },
         { 12345.0, "feet", "12300 × 6200 × 0 feet" }, { 0.5, "cubits", "0.5 × 0.25 × 0 cubits" },
         { 0.0, "mm", "" }, { 1.0, "", "" }, { 5e6, "km", "5000000 × 2500000 × 0 km" } })
  {
    auto model = Reported();
    model.unit = unit;
    model.box = {};
    model.box.Add(Vec3{ 0, 0, 0 });
    model.box.Add(Vec3{ longest, longest / 2, 0 });
    EXPECT_EQ(TextsOf(model).size, size);
  }
  auto huge = Reported();
  huge.box.Add(Vec3{ 1e308, 0, 0 });
  EXPECT_LT(TextsOf(huge).size.size(), 1300u);
}

TEST(ModelPage, ALongTitleIsCutInTheHeadOnly)
{
  auto model = Reported();
  model.title = std::string(2000, 'W');
  const auto page = MakeModelPage(viewerPage, model, known, "A museum");
  EXPECT_TRUE(Has(page, "<title>" + std::string(200, 'W') + "… – A museum</title>"));
  EXPECT_TRUE(Has(page, "<meta property=\"og:title\" content=\"" + std::string(200, 'W') + "…\">"));
  EXPECT_TRUE(Has(page, "<h1 dir=\"auto\">" + model.title + "</h1>"));
  EXPECT_EQ(DataOf(page)["name"], model.title);
}

TEST(ModelPage, ThePageOfAllModelsLinksToEach)
{
  std::vector<ModelSummary> models(2);
  models[0].id = "dragon";
  models[1].id = "vase";
  models[1].title = "A <b>vase</b>";
  const auto page = MakeListPage(viewerPage, models, known, { "A museum", "Of <things>." });
  for (const std::string part :
    { "<title>A museum</title>", "<meta name=\"description\" content=\"Of &lt;things&gt;.\">",
      "<link rel=\"canonical\" href=\"https://museum.example/3d/m/\">",
      "<meta property=\"og:title\" content=\"A museum\">", "<h1 dir=\"auto\">A museum</h1>",
      "<li dir=\"auto\"><a href=\"../m/dragon\">dragon</a></li>",
      "<a href=\"../m/vase\">A &lt;b&gt;vase&lt;/b&gt;</a>", "src=\"../page.js\"" })
  {
    EXPECT_TRUE(Has(page, part)) << part << "\n" << page;
  }
  const auto folder = MakeListPage(viewerPage, models, { {}, "../", true }, {});
  EXPECT_TRUE(Has(folder, "<title>Models</title>")) << folder;
  EXPECT_TRUE(Has(folder, "<a href=\"../m/dragon/\">dragon</a>"));
  for (const std::string& text : hostileTexts)
  {
    models[0].title = text;
    const auto hostile = MakeListPage(viewerPage, models, known, { text, text });
    for (const char* const tag : { "<script", "<title>", "<noscript", "<img", "<body", "<li" })
    {
      EXPECT_EQ(Count(hostile, tag), Count(page, tag)) << tag << " of " << text;
    }
  }
}

TEST(ModelPage, OtherPagesGetWhatTheyLack)
{
  EXPECT_TRUE(MakeModelPage("", Reported(), known, "").starts_with("<title>A dragon"));
  const auto bare =
    MakeModelPage("<html><head></head><body class=\"a\">x</body></html>", Reported(), known, "");
  EXPECT_TRUE(Has(bare, "<head><title>A dragon")) << bare;
  EXPECT_TRUE(Has(bare, "<body class=\"a\"><noscript>")) << bare;
  EXPECT_TRUE(Has(MakeModelPage("<title>a", Reported(), known, ""), "<h1"));
}

TEST(ModelPage, ARefusalSaysSo)
{
  const auto page =
    MakeRefusalPage(viewerPage, "There is no such model", "Gone.", known, "A museum");
  EXPECT_TRUE(Has(page, "<title>There is no such model – A museum</title>")) << page;
  EXPECT_TRUE(Has(page, "<meta name=\"robots\" content=\"noindex\">"));
  EXPECT_TRUE(Has(page, "<p dir=\"auto\">Gone.</p>"));
  EXPECT_TRUE(Has(page, "src=\"../page.js\"")) << "the viewer shows the others";
}

TEST(ModelPage, AnEmbeddedOneIsAsLargeAsItMayBe)
{
  const auto answer = [](const std::string& query)
  { return Json::parse(WriteEmbedAnswer(Reported(), known, "A museum", *ParseEmbedQuery(query))); };
  const auto usual = answer("url=https%3A%2F%2Fa.example%2Fm%2Fx&format=json&other=%3C");
  EXPECT_EQ(usual["version"], "1.0");
  EXPECT_EQ(usual["type"], "rich");
  EXPECT_EQ(usual["width"], 800);
  EXPECT_EQ(usual["height"], 600);
  EXPECT_EQ(usual["thumbnail_width"], 1200);
  EXPECT_EQ(usual["author_name"], "Stanford University");
  EXPECT_TRUE(Has(usual["html"], "<iframe src=\"https://museum.example/3d/m/dragon?embed\" "
                                 "width=\"800\" height=\"600\" title=\"A dragon\""))
    << usual["html"];
  const auto small = answer("maxwidth=320&maxheight=99999999999999999999999");
  EXPECT_EQ(small["width"], 320);
  EXPECT_EQ(small["height"], 600);
  EXPECT_FALSE(small.contains("thumbnail_url")) << "it is wider";
  EXPECT_TRUE(Has(small["html"], "width=\"320\" height=\"600\""));
  EXPECT_EQ(ParseEmbedQuery("url=a+b%2fc&url=d%20e")->url, "d e");
  for (const char* wrong :
    { "maxwidth=0", "maxheight=-1", "maxwidth=", "maxwidth=1x", "url=%2", "maxheight=%zz" })
  {
    EXPECT_EQ(ParseEmbedQuery(wrong).GetError().code, ErrorCode::InvalidArgument) << wrong;
  }
  EXPECT_EQ(ParseEmbedQuery("format=xml").GetError().code, ErrorCode::Unsupported);
  auto model = Reported();
  model.title = "\"><script>alert(1)</script>";
  const auto hostile = Json::parse(WriteEmbedAnswer(model, known, ""));
  EXPECT_EQ(hostile["title"], model.title);
  EXPECT_FALSE(Has(hostile["html"], "<script"));
}

TEST(ModelPage, AddressesNameModels)
{
  const std::string root = "https://museum.example/3d/";
  for (const char* address : { "https://museum.example/3d/m/dragon",
         "http://museum.example/3d/m/dragon/", "https://museum.example/3d/m/drag%6fn?embed#view=AA",
         "https://museum.example/3d/#model=dragon&view=A",
         "https://museum.example/3d/?lang=de#view=A&model=dragon" })
  {
    EXPECT_EQ(ModelOfAddress(address, root), "dragon") << address;
  }
  for (const char* address : { "", "https://museum.example/3d/", "https://museum.example/m/dragon",
         "https://other.example/3d/m/dragon", "https://museum.example/3d/m/",
         "https://museum.example/3d/m/a/b", "https://museum.example/3d/m/..%2f..",
         "https://museum.example/3d/#models=dragon", "//museum.example/3d/m/dragon",
         "https://museum.example/3d/m/.hidden", "https://museum.example/3d/m/%zz" })
  {
    EXPECT_EQ(ModelOfAddress(address, root), "") << address;
  }
  EXPECT_EQ(ModelOfAddress("https://a.example/m/x", ""), "");
  for (const char* good :
    { "https://a.example", "http://localhost:8700", "https://a.example/3d/", "http://[::1]:1" })
  {
    EXPECT_TRUE(IsPageRoot(good)) << good;
  }
  for (const char* bad : { "", "a.example", "ftp://a.example", "https://", "https:///x",
         "https://a.example/?x", "https://a/#b", "https://user@a.example", "https://a.example/\"",
         "https://a.example/ b", "https://a.example/\n" })
  {
    EXPECT_FALSE(IsPageRoot(bad)) << bad;
  }
}

TEST(ModelPage, TheManifestHasModelAndNotes)
{
  const std::vector<Note> notes{ { "The \"crack\"", "It is <old>.", "model=dragon&view=AX9", "en" },
    { "Only a title", "", "", "" } };
  const auto manifest = Json::parse(WriteIiifManifest(Reported(), { known.root, "../../" }, notes));
  EXPECT_EQ(manifest["@context"], "http://iiif.io/api/presentation/4/context.json");
  EXPECT_EQ(manifest["type"], "Manifest");
  EXPECT_EQ(manifest["id"], "https://museum.example/3d/m/dragon/manifest.json");
  EXPECT_EQ(manifest["label"]["none"][0], "A dragon");
  EXPECT_EQ(manifest["rights"], Reported().license);
  EXPECT_EQ(manifest["requiredStatement"]["value"]["none"][0], "Stanford University");
  EXPECT_EQ(manifest["homepage"][0]["id"], "https://museum.example/3d/m/dragon");
  EXPECT_EQ(manifest["thumbnail"][0]["width"], 1200);
  const auto& scene = manifest["items"][0];
  EXPECT_EQ(scene["type"], "Scene");
  const auto& painting = scene["items"][0]["items"][0];
  EXPECT_EQ(painting["motivation"][0], "painting");
  EXPECT_EQ(painting["body"]["type"], "Model");
  EXPECT_EQ(painting["body"]["format"], "model/gltf-binary");
  EXPECT_EQ(painting["body"]["id"],
    "https://museum.example/3d/api/models/dragon/0123456789abcdef0123456789abcdef/preview.glb");
  auto cloud = Reported();
  cloud.primitive = PrimitiveType::Points;
  EXPECT_EQ(Json::parse(WriteIiifManifest(
              cloud, known, {}))["items"][0]["items"][0]["items"][0]["body"]["id"],
    "https://museum.example/3d/api/models/dragon/model.json")
    << "there is no glTF of clouds";
  EXPECT_EQ(painting["target"]["id"], scene["id"]);
  const auto& first = scene["annotations"][0]["items"][0];
  EXPECT_EQ(first["motivation"][0], "commenting");
  EXPECT_EQ(first["label"]["en"][0], notes[0].title);
  EXPECT_EQ(first["body"]["value"], notes[0].text);
  EXPECT_EQ(first["target"]["selector"]["value"], notes[0].link);
  EXPECT_EQ(first["target"]["source"]["id"], scene["id"]);
  EXPECT_EQ(scene["annotations"][0]["items"][1]["body"]["value"], "Only a title");
  const auto relative = Json::parse(WriteIiifManifest(Reported(), { {}, "../../" }, {}));
  EXPECT_EQ(relative["homepage"][0]["id"], "../../m/dragon");
  EXPECT_FALSE(relative["items"][0].contains("annotations"));
  for (const std::string& text : hostileTexts)
  {
    auto model = Reported();
    model.title = model.credit = model.license = model.description = text;
    EXPECT_TRUE(Json::accept(
      WriteIiifManifest(model, known, std::vector<Note>{ { text, text, text, text } })))
      << text;
  }
  auto marked = Reported();
  marked.credit = "<b>Ann</b>";
  const auto plain = Json::parse(WriteIiifManifest(marked, known, {}));
  EXPECT_EQ(plain["requiredStatement"]["value"]["none"][0], "<b>Ann</b> ")
    << "what ends with a space is no HTML to viewers";
}
