// SPDX-License-Identifier: BSD-3-Clause
// Tilesets as a server makes them on request. The tiles are the same as kdstream-store exports,
// boxes enclose everything below them, tokens decide how deep tilesets go, and the original's tiles
// count.
#include "server/access/Testing/ForgedToken.h"
#include "server/http/Routes.h"

#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Sanitized.h"
#include "filters/build/Builder.h"
#include "filters/protocol/ResourcePath.h"
#include "server/http/Testing/ServerTest.h"
#include "server/http/Testing/WholeAnswer.h"
#include "server/session/StoreCatalog.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>

using namespace kdstream;

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string BodyOf(const HttpResponse& response)
{
  return response.body ? std::string(response.body->begin(), response.body->end()) : "";
}

// The two corners of a tile's box, whose axes are the axes of the coordinates.
std::pair<Vec3, Vec3> EndsOf(const Json& tile)
{
  const auto& box = tile["boundingVolume"]["box"];
  Vec3 low{}, high{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double middle = box[k], half = box[3 + 4 * k];
    low[k] = middle - half;
    high[k] = middle + half;
  }
  return { low, high };
}

bool Encloses(const Json& outer, const Json& inner)
{
  const auto [low, high] = EndsOf(outer);
  const auto [from, to] = EndsOf(inner);
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double little = 1e-9 * (high[k] - low[k]);
    if (from[k] < low[k] - little || to[k] > high[k] + little)
    {
      return false;
    }
  }
  return true;
}

class ServedTiles : public testing::Test
{
protected:
  fixtures::TemporaryFolder folder;
  std::unique_ptr<StoreCatalog> catalog;
  Metrics metrics;
  std::unique_ptr<Routes> routes;

  // Builds a store whose levels are cut into several pieces; some are numbered by rank, others by
  // partition.
  void Build(const Mesh& mesh = fixtures::HeightField(180), std::uint32_t perPartition = 60,
    std::uint32_t cellVertices = 1)
  {
    BuildOptions options;
    options.tree.verticesPerPartition = perPartition;
    options.tree.cellVertices = cellVertices;
    options.credit = "Ann";
    options.unit = "mm";
    const auto built = BuildStore(mesh, "hill.ply", this->folder / "hill.kds", options);
    ASSERT_TRUE(built) << built.GetError().message;
    this->Open();
  }
  void Open(RouteOptions options = {})
  {
    this->routes.reset();
    this->catalog =
      std::make_unique<StoreCatalog>(this->folder.Path, [](const auto&, const auto&) {});
    ASSERT_TRUE(this->catalog->Reload());
    this->routes = std::make_unique<Routes>(*this->catalog, this->metrics, std::move(options));
  }
  void OpenGuarded(std::shared_ptr<const PartitionLedger> ledger = {})
  {
    RouteOptions options;
    options.guard =
      std::make_shared<const TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; });
    options.ledger = std::move(ledger);
    this->Open(std::move(options));
  }

  static std::string Token(const std::string& detail)
  {
    return forged::Token(
      forged::header, R"({"sub":"ann","exp":2000,"models":["hill"],"detail":")" + detail + "\"}");
  }
  HttpResponse Get(const std::string& path, const std::string& token = {},
    const std::string& tag = {}, const std::string& method = "GET") const
  {
    HttpRequest request{ method, path, tag, "", "" };
    request.authorization = token.empty() ? "" : "Bearer " + token;
    return Answer(*this->routes, request);
  }

  const std::string base = "/api/models/hill/3dtiles/";

  // Calls visit(tile, path of its content below the tileset's folder, or "") for all tiles,
  // including those of external tilesets. Checks that the boxes and errors of tiles enclose those
  // of their children.
  void Walk(const std::string& token,
    const std::function<void(const Json&, const std::string&)>& visit, std::string file = {}) const
  {
    file = file.empty() ? "tileset.json" : file;
    const auto response = this->Get(this->base + file, token);
    ASSERT_EQ(response.status, 200u) << file << BodyOf(response);
    EXPECT_EQ(response.Field("Content-Type"), "application/json");
    const std::function<void(const Json&)> walk = [&](const Json& tile)
    {
      std::string content;
      if (tile.contains("content"))
      {
        content = (fs::path(file).parent_path() / tile["content"]["uri"].get<std::string>())
                    .lexically_normal();
      }
      if (content.ends_with(".json"))
      {
        this->Walk(token, visit, content);
        return;
      }
      visit(tile, content);
      for (const Json& child : tile.value("children", Json::array()))
      {
        EXPECT_TRUE(Encloses(tile, child)) << content;
        EXPECT_LE(child["geometricError"], tile["geometricError"]);
        walk(child);
      }
    };
    walk(Json::parse(BodyOf(response))["root"]);
  }
  // The contents by their path without the version: "11/0.glb" and so on.
  std::map<std::string, std::string> Contents(const std::string& token = {}) const
  {
    std::map<std::string, std::string> found;
    this->Walk(token,
      [&](const Json&, const std::string& content)
      {
        if (!content.empty())
        {
          found[content.substr(content.find('/') + 1)] = this->base + content;
        }
      });
    return found;
  }
};

}

TEST_F(ServedTiles, TheyAreTheExportedOnes)
{
  // The large model has levels that are numbered by rank and have several pieces, and tilesets in
  // tilesets. It is too slow with a sanitizer.
  this->Build(
    fixtures::HeightField(fixtures::sanitized ? 120 : 370), fixtures::sanitized ? 60 : 120);
  const auto& depths = this->catalog->Find("hill")->Description().depths;
  ASSERT_TRUE(fixtures::sanitized || depths.stitch > 12u);
  const auto exported = fixtures::RunTool(
    this->folder, "store", { "export", "hill.kds", "tiles", "--format", "3dtiles", "--quiet" });
  ASSERT_EQ(exported.exitCode, 0) << exported.err;
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(this->folder / "tiles"))
  {
    if (entry.path().extension() == ".glb")
    {
      files.insert(entry.path().lexically_relative(this->folder / "tiles"));
    }
  }
  EXPECT_TRUE(fixtures::sanitized || fs::exists(this->folder / "tiles" / "18" / "0.json"));
  EXPECT_LT(this->Get(this->base + "tileset.json").length, 70'000u);
  const auto contents = this->Contents();
  ASSERT_EQ(contents.size(), files.size());
  EXPECT_GT(files.size(), 100u);
  for (const auto& [name, path] : contents)
  {
    ASSERT_EQ(files.count(name), 1u) << name;
    const auto response = this->Get(path);
    ASSERT_EQ(response.status, 200u) << name << BodyOf(response);
    EXPECT_EQ(response.Field("Content-Type"), "model/gltf-binary");
    EXPECT_EQ(BodyOf(response), fixtures::ReadWhole(this->folder / "tiles" / name)) << name;
  }
}

// If many partitions are below one piece of the finest level, groups of them have tilesets.
TEST_F(ServedTiles, GroupsOfPartitionsHaveTilesets)
{
  this->Build(fixtures::HeightField(100), 10, 200);
  const auto exported = fixtures::RunTool(
    this->folder, "store", { "export", "hill.kds", "tiles", "--format", "3dtiles", "--quiet" });
  ASSERT_EQ(exported.exitCode, 0) << exported.err;
  std::vector<std::string> groups;
  std::size_t partitions = 0; // tiles that show something
  for (const auto& entry : fs::directory_iterator(this->folder / "tiles" / "original"))
  {
    partitions += entry.path().extension() == ".glb";
    if (entry.path().extension() == ".json")
    {
      groups.push_back(entry.path().filename());
    }
  }
  ASSERT_GE(groups.size(), 16u);
  EXPECT_GT(partitions, 500u);
  const auto contents = this->Contents();
  EXPECT_EQ(contents.size(), partitions + 1) << "there is one level";
  const std::string tile = contents.at("original/0.glb");
  const std::string original = tile.substr(0, tile.rfind('/') + 1);
  for (const std::string& group : groups)
  {
    const auto response = this->Get(original + group);
    EXPECT_EQ(response.status, 200u) << group;
    EXPECT_LT(response.length, 70'000u);
    EXPECT_EQ(this->Get(original + group.substr(0, group.find('.')) + "0.json").status, 404u);
  }
  for (const char* const none : { "0.json", "1.json", "1073741823.json" })
  {
    EXPECT_EQ(this->Get(original + none).status, 404u) << none;
  }
  this->OpenGuarded();
  EXPECT_EQ(this->Get(original + groups[0]).status, 401u);
  EXPECT_EQ(this->Get(original + groups[0], Token("levels")).status, 403u);
  EXPECT_EQ(this->Get(original + groups[0], Token("regions")).status, 200u);
  EXPECT_EQ(this->Contents(Token("levels")).size(), 1u);
}

// Exported boxes just enclose what is shown. Served boxes are larger, so they enclose all of that,
// too.
TEST_F(ServedTiles, BoxesEncloseTheExportedOnes)
{
  this->Build(fixtures::DisplacedSphere(5));
  const auto exported = fixtures::RunTool(
    this->folder, "store", { "export", "hill.kds", "tiles", "--format", "3dtiles", "--quiet" });
  ASSERT_EQ(exported.exitCode, 0) << exported.err;
  std::map<std::string, Json> tight;
  const std::function<void(const Json&, const fs::path&)> read =
    [&](const Json& tile, const fs::path& from)
  {
    const std::string content =
      tile.contains("content")
        ? (from / tile["content"]["uri"].get<std::string>()).lexically_normal().string()
        : "";
    if (content.ends_with(".json"))
    {
      read(Json::parse(fixtures::ReadWhole(this->folder / "tiles" / content))["root"],
        fs::path(content).parent_path());
      return;
    }
    tight[content] = tile;
    for (const Json& child : tile.value("children", Json::array()))
    {
      read(child, from);
    }
  };
  read(Json::parse(fixtures::ReadWhole(this->folder / "tiles" / "tileset.json"))["root"], {});
  std::size_t compared = 0;
  this->Walk({},
    [&](const Json& tile, const std::string& content)
    {
      if (!content.empty())
      {
        const Json& other = tight.at(content.substr(content.find('/') + 1));
        EXPECT_TRUE(Encloses(tile, other)) << content;
        EXPECT_EQ(tile["geometricError"], other["geometricError"]);
        ++compared;
      }
    });
  EXPECT_GT(compared, 20u);
}

TEST_F(ServedTiles, TheyAreCachedByWhatTheyAre)
{
  this->Build();
  const auto root = this->Get(this->base + "tileset.json");
  EXPECT_EQ(root.Field("Cache-Control"), "no-cache");
  const auto tag = std::string(root.Field("ETag"));
  EXPECT_EQ(this->Get(this->base + "tileset.json", {}, tag).status, 304u);
  EXPECT_EQ(Json::parse(BodyOf(root))["root"]["refine"], "REPLACE");

  const auto misses = [this]
  {
    const std::string text = BodyOf(this->Get("/metrics")), name = "\nkdstream_tile_misses_total ";
    const std::size_t at = text.find(name);
    return at == std::string::npos ? -1 : std::stoi(text.substr(at + name.size()));
  };
  const std::string tile = this->Contents().at("original/0.glb");
  const int before = misses(); // for tilesets
  EXPECT_GT(before, 0);
  const auto first = this->Get(tile);
  EXPECT_EQ(first.Field("Cache-Control"), "public, max-age=31536000, immutable");
  EXPECT_EQ(this->Get(tile, {}, std::string(first.Field("ETag"))).status, 304u);
  EXPECT_EQ(this->Get(tile, {}, "", "HEAD").length, first.length);
  const auto found = this->routes->Find({ "GET", tile, "", "", "" });
  ASSERT_TRUE(std::holds_alternative<HttpResponse>(found)) << "it is in memory";
  EXPECT_EQ(std::get<HttpResponse>(found).body, first.body);
  EXPECT_EQ(misses(), before + 1);

  // Another description is another version, because the tiles contain its credit.
  const auto edited =
    fixtures::RunTool(this->folder, "store", { "edit", "hill.kds", "--credit", "Ben", "--quiet" });
  ASSERT_EQ(edited.exitCode, 0) << edited.err;
  this->Open();
  EXPECT_EQ(this->Get(tile).status, 410u);
  EXPECT_EQ(this->Get(this->base + "tileset.json", {}, tag).status, 200u);
}

TEST_F(ServedTiles, ATokensDetailDecidesHowDeepTheyGo)
{
  this->Build();
  const auto all = this->Contents();
  const auto levels = this->catalog->Find("hill")->Description().levels.size();
  this->OpenGuarded();
  EXPECT_EQ(this->Get(this->base + "tileset.json").status, 401u);
  EXPECT_EQ(this->Get(all.at("11/0.glb")).status, 401u);
  const auto preview = this->Contents(Token("preview"));
  ASSERT_EQ(preview.size(), 1u);
  EXPECT_EQ(preview.begin()->first, "11/0.glb");
  const auto some = this->Contents(Token("levels"));
  for (const auto& [name, path] : all)
  {
    EXPECT_EQ(some.count(name) == 0, name.starts_with("original/")) << name;
  }
  EXPECT_EQ(this->Contents(Token("regions")).size(), all.size());

  const std::string finest = std::to_string(levels - 1) + "/0.glb";
  EXPECT_EQ(this->Get(all.at(finest), Token("levels")).status, 200u);
  EXPECT_EQ(this->Get(all.at(finest), Token("preview")).status, 403u);
  EXPECT_EQ(this->Get(all.at("original/0.glb"), Token("levels")).status, 403u);
  const auto tile = this->Get(all.at("original/0.glb"), Token("regions"));
  EXPECT_EQ(tile.status, 200u);
  EXPECT_EQ(tile.Field("Cache-Control"), "private, max-age=31536000, immutable");
  EXPECT_EQ(tile.Field("Vary"), "Authorization");
  EXPECT_NE(this->Get(this->base + "tileset.json", Token("levels")).Field("ETag"),
    this->Get(this->base + "tileset.json", Token("regions")).Field("ETag"));
  const auto stranger = forged::Token(
    forged::header, R"({"sub":"ann","exp":2000,"models":["vase"],"detail":"regions"})");
  EXPECT_EQ(this->Get(this->base + "tileset.json", stranger).status, 403u);
}

TEST_F(ServedTiles, TilesOfTheOriginalCountAsItsPartitions)
{
  this->Build();
  const auto all = this->Contents();
  std::vector<PartitionRecord> taken;
  QuotaLimits limits;
  limits.share = 1.5 / double(this->catalog->Find("hill")->Description().partitions);
  auto book = QuotaBook::Open(this->folder / "quotas.db", limits);
  ASSERT_TRUE(book) << book.GetError().message;
  this->OpenGuarded(std::make_shared<const PartitionLedger>(
    std::move(*book), [&](const PartitionRecord& record) { taken.push_back(record); }, [] {}));
  const auto token = Token("regions");
  EXPECT_EQ(this->Contents(token).size(), all.size()) << "tilesets count nothing";
  EXPECT_EQ(this->Get(all.at("11/0.glb"), token).status, 200u);
  EXPECT_TRUE(taken.empty());

  HttpRequest request{ "GET", all.at("original/3.glb"), "", "", "" };
  request.authorization = "Bearer " + token;
  const auto found = this->routes->Find(request);
  const auto& reading = std::get<Routes::Reading>(found);
  EXPECT_FALSE(reading.Uncounted()) << "it counts, and is not given for nothing";
  EXPECT_TRUE(taken.empty());
  const auto first = reading.Answer();
  ASSERT_EQ(first.status, 200u);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].partition, 3u);
  EXPECT_EQ(taken[0].subject, "ann");
  const auto model = this->catalog->Find("hill");
  EXPECT_EQ(taken[0].bytes, *model->BlobSize(protocol::BlobId::Partition(3)));

  EXPECT_EQ(
    this->Get(all.at("original/3.glb"), token, std::string(first.Field("ETag"))).status, 304u);
  EXPECT_EQ(this->Get(all.at("original/4.glb"), token, "", "HEAD").status, 200u);
  EXPECT_EQ(taken.size(), 1u) << "no byte was sent";
  EXPECT_EQ(this->Get(all.at("original/4.glb"), token).status, 403u) << "beyond the share";
  EXPECT_EQ(
    this
      ->Get(protocol::BlobPath("hill", model->Description().digest, protocol::BlobId::Partition(3)),
        token)
      .status,
    200u)
    << "the partition and its tile count once";
}

TEST_F(ServedTiles, OtherAddressesAreRefused)
{
  this->Build(fixtures::DisplacedSphere(4));
  const auto root = Json::parse(BodyOf(this->Get(this->base + "tileset.json")))["root"];
  const std::string uri = root["content"]["uri"];
  const std::string version = uri.substr(0, uri.find('/'));
  const auto status = [&](const std::string& below)
  { return this->Get(this->base + below).status; };
  EXPECT_EQ(status(version + "/11/0.glb"), 200u);
  for (const char* const missing : { "/11/1.glb", "/10/0.glb", "/30/0.glb", "/11/0.json",
         "/original/0.json", "/original/64.json", "/original/1073741823.json",
         "/original/100000.glb", "/original/1073741823.glb", "/tileset.json", "/11/0.b3dm", "/11/0",
         "/11", "/11/0/0.glb", "/", "/levels/../tileset.json" })
  {
    EXPECT_EQ(status(version + missing), 404u) << missing;
  }
  for (const char* const wrong :
    { "/31/0.glb", "/011/0.glb", "/-1/0.glb", "/11/00.glb", "/11/-1.glb", "/11/+1.glb",
      "/11/4294967296.glb", "/original/1073741824.glb", "/11/18446744073709551616.glb", "/11/.glb",
      "/11/%30.glb", "/../0.glb", "/11%2f0.glb/0.glb", "/Original/0.glb" })
  {
    EXPECT_EQ(status(version + wrong), 400u) << wrong;
  }
  EXPECT_EQ(status("../tileset.json"), 404u);
  EXPECT_EQ(status("%2e%2e/11/0.glb"), 400u);
  EXPECT_EQ(status("abc/11/0.glb"), 400u);
  EXPECT_EQ(status(std::string(32, '0') + "/11/0.glb"), 410u);
  EXPECT_EQ(status(""), 404u);
  EXPECT_EQ(this->Get("/api/models/lucy/3dtiles/tileset.json").status, 404u);
  EXPECT_EQ(this->Get("/api/models/../3dtiles/tileset.json").status, 400u);
  EXPECT_EQ(this->Get(this->base + "tileset.json", {}, {}, "POST").status, 405u);
}

TEST_F(ServedTiles, OtherSitesMayHaveThemWhereTheApiMay)
{
  this->Build(fixtures::DisplacedSphere(4));
  RouteOptions options;
  options.allowOrigin = "https://globe.example";
  this->Open(std::move(options));
  EXPECT_EQ(this->Get(this->base + "tileset.json").Field("Access-Control-Allow-Origin"),
    "https://globe.example");
  const auto preflight = this->Get(this->base + "tileset.json", {}, {}, "OPTIONS");
  EXPECT_EQ(preflight.status, 204u);
}

TEST_F(ServedTiles, CloudsAndStoresWithoutLevels)
{
  this->Build(fixtures::Cloud(5));
  for (const auto& [name, path] : this->Contents())
  {
    EXPECT_EQ(BodyOf(this->Get(path)).substr(0, 4), "glTF") << name;
  }
  MemoryCatalog memory;
  const auto model = memory.Add("octree", 1, 4, 3000);
  model->Retell().levels.clear();
  const Routes others(memory, this->metrics, {});
  EXPECT_EQ(
    Answer(others, { "GET", "/api/models/octree/3dtiles/tileset.json", "", "", "" }).status, 404u);
}

// A piece that cannot be read is a failure of the server, and nothing of it is kept.
TEST_F(ServedTiles, DamageIsNotATile)
{
  MemoryCatalog memory; // its blobs are not pieces
  memory.Add("hill", 1, 4, 3000);
  const Routes others(memory, this->metrics, {});
  const HttpRequest request{ "GET", this->base + "tileset.json", "", "", "" };
  EXPECT_EQ(Answer(others, request).status, 500u);
  EXPECT_EQ(Answer(others, request).status, 500u);
}
