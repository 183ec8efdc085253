// SPDX-License-Identifier: BSD-3-Clause
// The description as in stores, and as statistics.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Testing/RandomModels.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <tuple>
#include <vector>

using namespace kdstream;
using Json = nlohmann::json;

namespace
{

// From a store of version 9, with three numbers made difficult.
constexpr const char* earlier =
  R"({"attributes":[{"association":0,"components":3,"name":"RGB","type":1}],"box":{"hi":[0.59230)"
  R"(49449920654,1.7963732481002808,1e+16],"lo":[-0.5922176837921143,-0.0,-0.592219889163971]},"c)"
  R"(redit":"","digest":"edc48d04297f7be1de5a54296df8dee3","finest_depth":1,"grid":{"bits":20,"or)"
  R"(igin":[-0.5922176837921143,-0.0021240930072963238,-0.592219889163971],"scalar_type":0,"step")"
  R"(:1.7151823580645897e-06},"inconsistent_edges":2,"input":"vase.ply","largest_partition":4932,)"
  R"("level_maker":"collapse","levels":[{"bytes":71,"depth":0,"deviation":0.5620144605636597,"dev)"
  R"(iation_99":1.8119888305664063,"pieces":1,"spacing":4096,"triangles":0,"vertices":1},{"bytes":160,"depth":1,")"
  R"(deviation":0.4589047431945801,"deviation_99":0.363817423582077,"pieces":1,"spacing":7,"triangles":4,"ver)"
  R"(tices":4}],"license":"","original":{"bytes":39299,"deviation":0.0,"deviation_99":0.0,"pieces)"
  R"(":1,"triangles":9860,"vertices":4932},"partition_depth":0,"partitioner":"kdtree","partitions)"
  R"(":1,"primitive":1,"representative":"quadric","sheets":true,"smallest_partition":4931,"stitch)"
  R"(_depth":1,"title":"Übung \"1\"","triangles":9860,"unit":"mm","vertices":4932,"weld":true,"we)"
  R"(lded":3})";

// The same from a store of version 13. Stores of the same version must have the same bytes forever.
constexpr const char* written =
  R"({"digest":"edc48d04297f7be1de5a54296df8dee3","vertices":4932,"triangles":9860,"partitions":1)"
  R"(,"box":{"lo":[-0.5922176837921143,-0.0,-0.592219889163971],"hi":[0.5923049449920654,1.796373)"
  R"(2481002808,10000000000000000.0]},"partition_depth":0,"stitch_depth":1,"finest_depth":1,"prec)"
  R"(ision":{"scalar_type":"float32","origin":[-0.5922176837921143,-0.0021240930072963238,-0.5922)"
  R"(19889163971],"step":0.0000017151823580645897,"bits":20},"primitive":"triangles","levels":[{")"
  R"(depth":0,"vertices":1,"triangles":0,"pieces":1,"bytes":71,"deviation":0.5620144605636597,"de)"
  R"(viation_99":1.8119888305664062,"spacing":4096},{"depth":1,"vertices":4,"triangles":4,"pieces)"
  R"(":1,"bytes":160,"deviation":0.4589047431945801,"deviation_99":0.363817423582077,"spacing":7})"
  R"(],"original":{"vertices":4932,"triangles":9860,"pieces":1,"bytes":39299,"deviation":0.0,"dev)"
  R"(iation_99":0.0},"title":"Übung \"1\"","credit":"","license":"","unit":"mm","attributes":[{"n)"
  R"(ame":"RGB","type":"uint8","association":"point","components":3}],"build":{"input":"vase.ply")"
  R"(,"welded":3,"inconsistent_edges":2,"smallest_partition":4931,"largest_partition":4932,"parti)"
  R"(tioner":"kdtree","level_maker":"collapse","representative":"quadric","sheets":true,"weld":tr)"
  R"(ue}})";

bool Parses(const Json& json)
{
  return ParseStoredModel(json.dump()).HasValue();
}

bool ParsesEarlier(const Json& json)
{
  return ParseStoredModel(json.dump(), StoredForm::Earlier).HasValue();
}

}

TEST(TestStoredModel, TheTextOfAStoreStaysAsItIsToTheByte)
{
  const auto model = ParseStoredModel(written);
  ASSERT_TRUE(model) << model.GetError().message;
  EXPECT_EQ(WriteStoredModel(*model), written);
  EXPECT_EQ(model->input, "vase.ply");
  EXPECT_EQ(model->smallestPartition, 4931u);
  EXPECT_EQ(model->grid.step, 1.7151823580645897e-06);
  EXPECT_EQ(model->levels.at(1).geometricError99, 0.363817423582077);
  EXPECT_EQ(model->levels.at(1).spacing, 7U);
  EXPECT_EQ(model->Codec().spacings, (std::vector<std::uint32_t>{ 4096, 7 }));
  EXPECT_TRUE(model->HasPiece({ Resolution::Level(1), 1 }));
  EXPECT_FALSE(model->HasPiece({ Resolution::Level(2), 1 }));
  EXPECT_FALSE(model->HasPiece({ Resolution::Original(), 2 }));
}

TEST(TestStoredModel, EarlierStoresSayTheSame)
{
  const auto model = ParseStoredModel(earlier, StoredForm::Earlier);
  ASSERT_TRUE(model) << model.GetError().message;
  EXPECT_EQ(*model, *ParseStoredModel(written));
  EXPECT_FALSE(ParseStoredModel(earlier));
  EXPECT_FALSE(ParseStoredModel(written, StoredForm::Earlier));
}

// Servers send what is stored, with the id added at the beginning, and without the build at the
// end.
TEST(TestStoredModel, ServersSendWhatStoresKeep)
{
  RandomModels random(3);
  for (int i = 0; i < 100; ++i)
  {
    ModelDescription model = random.Model();
    model.detail = ModelDetail::Regions;
    const std::string kept = WriteStoredModel(model);
    const std::string reported = WriteModel(model);
    const std::string id = "{\"id\":\"" + model.id + "\",";
    ASSERT_EQ(reported.substr(0, id.size()), id);
    const std::string described = reported.substr(id.size(), reported.size() - id.size() - 1);
    EXPECT_EQ(kept.substr(0, described.size() + 11), "{" + described + ",\"build\":{");
  }
}

TEST(TestStoredModel, ComesBack)
{
  RandomModels random(1);
  for (int i = 0; i < 500; ++i)
  {
    ModelDescription model = random.Model();
    model.id.clear(); // a store does not contain its own id
    const bool levels = i % 2 == 0;
    model.depths.finest = levels ? model.depths.finest : model.depths.partition;
    model.depths.stitch = std::min(model.depths.finest, model.depths.partition + 4);
    model.partitions = std::uint64_t{ 1 } << model.depths.partition;
    model.levels.assign(levels ? model.depths.finest + 1u : 0u, random.Resolution(true));
    model.partitioner = levels ? "kdtree" : i % 3 == 0 ? "octree" : "kmeans";
    for (AttributeInfo& attribute : model.attributes)
    {
      attribute.name = "name é";
    }
    random.AddScalars(model);
    model.input = random.Text(20);
    model.inputDigest = i % 3 == 0 ? "" : random.Digest();
    model.levelMaker = random.Text(5);
    model.sheets = random.Integer(0, 1) == 1;
    model.weld = random.Integer(0, 1) == 1;
    model.welded = random.Integer(0, 1ull << 53);
    if (i % 4 == 0)
    {
      model.unused = { random.Integer(1, 1ull << 53), random.Integer(0, 1ull << 53),
        { 1, -0.5, double(i) } };
    }
    const auto parsed = ParseStoredModel(WriteStoredModel(model));
    ASSERT_TRUE(parsed) << parsed.GetError().message << "\n" << WriteStoredModel(model);
    EXPECT_EQ(*parsed, model);
  }
}

TEST(TestStoredModel, RangesOfNumbersAreChecked)
{
  ModelDescription model = *ParseStoredModel(written);
  model.attributes.push_back({ "intensity", AttributeType::UInt16 });
  model.attributes.push_back({ "kind", AttributeType::UInt8 });
  model.scalars = std::vector<ScalarDescription>{ { "intensity", 1, 9, 2, 8, {} },
    { "kind", 0, 6, 0, 6, { { 0, 5 }, { 6, 7 } } } };
  const auto good = Json::parse(WriteStoredModel(model));
  ASSERT_EQ(*ParseStoredModel(good.dump()), model);
  const std::string none = "\"scalars\"";
  const std::tuple<const char*, Json, std::string> wrong[] = {
    { "/scalars/0/range/0", 2.5, none },
    { "/scalars/0/range/1", 8.5, none },
    { "/scalars/0/range/3", 7, none },
    { "/scalars/0/range/2", "8", none },
    { "/scalars/0/range", Json::array({ 1, 2, 3 }), none },
    { "/scalars/0/range", std::vector<int>(5, 1), "" },
    { "/scalars/1/classes/2", -1, none },
    { "/scalars/1/classes/3", -1, none },
    { "/scalars/1/classes/0", nullptr, none },
    { "/scalars/0/name", 7, "" },
    { "/scalars", Json::array({ 1 }), "" },
    { "/scalars", std::vector<Json>(17, good["scalars"][0]), "" },
    { "/scalars/1/classes", std::vector<int>(513, 1), "" },
  };
  for (const auto& [place, value, named] : wrong)
  {
    Json changed = good;
    changed[Json::json_pointer(place)] = value;
    const auto parsed = ParseStoredModel(changed.dump());
    EXPECT_TRUE(fixtures::FailsAt(parsed, ErrorCode::Damaged, named)) << place << " " << value;
  }
}

// Members that servers also send are checked by TestModelDescription.
TEST(TestStoredModel, EveryMemberOfTheBuildIsChecked)
{
  const auto good = Json::parse(written);
  ASSERT_TRUE(Parses(good));
  const std::pair<const char*, Json> wrong[] = {
    { "/digest", "abc" },
    { "/partitions", 2 },
    { "/stitch_depth", 0 },
    { "/levels", Json::array() },
    { "/attributes/0/name", "" },
    { "/attributes/0/name", "a\nb" },
    { "/build", 7 },
    { "/build/input", nullptr },
    { "/build/input_digest", 7 },
    { "/build/input_digest", "abc" },
    { "/build/input_digest", std::string(32, 'g') },
    { "/build/partitioner", "octree" }, // octrees have no levels
    { "/build/partitioner", "quadtree" },
    { "/build/sheets", 1 },
    { "/build/weld", "on" },
    { "/build/welded", -1 },
  };
  for (const auto& [place, value] : wrong)
  {
    Json bad = good;
    bad[Json::json_pointer(place)] = value;
    EXPECT_FALSE(Parses(bad)) << place << " = " << value;
  }
  for (const auto& [key, value] : good["build"].items())
  {
    Json bad = good;
    bad["build"].erase(key);
    EXPECT_FALSE(Parses(bad)) << key;
  }
}

TEST(TestStoredModel, EveryMemberOfEarlierOnesIsChecked)
{
  const auto good = Json::parse(earlier);
  ASSERT_TRUE(ParsesEarlier(good));
  const std::pair<const char*, Json> wrong[] = {
    { "/digest", 5 },
    { "/input", nullptr },
    { "/input_digest", 7 },
    { "/input_digest", "abc" },
    { "/input_digest", std::string(32, 'g') },
    { "/vertices", -1 },
    { "/vertices", 0 },
    { "/triangles", "7" },
    { "/partitions", 2 },
    { "/partition_depth", 31 },
    { "/partition_depth", 1 },
    { "/finest_depth", 2 },
    { "/finest_depth", 4294967296 },
    { "/stitch_depth", 0 },
    { "/partitioner", "octree" }, // octrees have no levels
    { "/partitioner", "quadtree" },
    { "/box/hi/0", -1 },
    { "/box/lo", Json::array({ 1, 2 }) },
    { "/grid/bits", 7 },
    { "/grid/bits", 25 },
    { "/grid/step", 0 },
    { "/grid/scalar_type", 2 },
    { "/primitive", 2 },
    { "/levels", Json::array() },
    { "/levels/1", 7 },
    { "/levels/1/depth", 0 },
    { "/levels/1/bytes", 1.5 },
    { "/levels/1/deviation_99", nullptr },
    { "/levels/1/spacing", nullptr },
    { "/levels/1/spacing", 0 },
    { "/levels/1/spacing", (1 << 24) + 1 },
    { "/original/pieces", "many" },
    { "/attributes/0", 7 },
    { "/attributes/0/type", 10 },
    { "/attributes/0/association", 2 },
    { "/attributes/0/components", 0 },
    { "/attributes/0/components", 256 },
    { "/attributes/0/name", "" },
    { "/attributes/0/name", "a\nb" },
    { "/sheets", 1 },
    { "/weld", "on" },
    { "/welded", -1 },
  };
  for (const auto& [place, value] : wrong)
  {
    Json bad = good;
    bad[Json::json_pointer(place)] = value;
    EXPECT_FALSE(ParsesEarlier(bad)) << place << " = " << value;
  }
  for (const auto& [key, value] : good.items())
  {
    Json bad = good;
    bad.erase(key);
    const bool optional = key == "title" || key == "credit" || key == "license" || key == "unit";
    EXPECT_EQ(ParsesEarlier(bad), optional) << key;
  }
}

TEST(TestStoredModel, UnusedVerticesAreChecked)
{
  ModelDescription model = *ParseStoredModel(written);
  model.unused = { 3, 70, { 0, 0, 9 } };
  const auto good = Json::parse(WriteStoredModel(model));
  ASSERT_TRUE(Parses(good));
  const std::pair<const char*, Json> wrong[] = { { "/build/unused", 7 },
    { "/build/unused/vertices", 0 }, { "/build/unused/vertices", (1ull << 53) + 1 },
    { "/build/unused/bytes", -1 }, { "/build/unused/farthest", { 0, 0 } },
    { "/build/unused/farthest/0", nullptr } };
  for (const auto& [place, value] : wrong)
  {
    Json bad = good;
    bad[Json::json_pointer(place)] = value;
    EXPECT_FALSE(Parses(bad)) << place << " = " << value;
  }
}

TEST(TestStoredModel, DamageSaysWhichMember)
{
  Json bad = Json::parse(written);
  bad["precision"]["step"] = -1;
  const auto parsed = ParseStoredModel(bad.dump());
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.GetError().code, ErrorCode::Damaged);
  EXPECT_NE(parsed.GetError().message.find("the metadata: \"step\" is \"-1\""), std::string::npos)
    << parsed.GetError().message;
  for (const char* text : { "", "[]", "null", "{\"digest\":", "7" })
  {
    const auto none = ParseStoredModel(text);
    ASSERT_FALSE(none) << text;
    EXPECT_EQ(none.GetError().code, ErrorCode::Damaged) << text;
  }
}

TEST(TestStoredModel, StatisticsHaveTheDocumentedKeys)
{
  JsonWriter writer({ 2 });
  writer.BeginObject();
  auto model = *ParseStoredModel(written);
  EXPECT_EQ(model.inputDigest, "") << "of a store that does not tell";
  model.inputDigest = std::string(32, 'a');
  model.unused = { 3, 70, { 0, 0, 9 } };
  PutStatistics(writer, model, 1234);
  writer.EndObject();
  const Json json = Json::parse(writer.Text());
  EXPECT_EQ(json["input"], "vase.ply");
  EXPECT_EQ(json["input_digest"], std::string(32, 'a'));
  EXPECT_EQ(json["partition_vertices"], (Json{ { "min", 4931 }, { "max", 4932 } }));
  EXPECT_EQ(json["partition_bytes"], 39299);
  EXPECT_EQ(json["precision"], 20);
  EXPECT_EQ(json["scalar_type"], "float32");
  EXPECT_EQ(json["primitive"], "triangles");
  EXPECT_EQ(json["attributes"][0]["type"], "uint8");
  EXPECT_EQ(json["attributes"][0]["association"], "point");
  EXPECT_EQ(json["levels"][1]["depth"], 1);
  EXPECT_EQ(json["levels"][1]["deviation_99"], 0.363817423582077);
  EXPECT_EQ(json["store_bytes"], 1234);
  EXPECT_EQ(
    json["unused"], (Json{ { "vertices", 3 }, { "bytes", 70 }, { "farthest", { 0, 0, 9 } } }));
  for (const char* key : { "vertices", "triangles", "partitions", "partition_depth", "stitch_depth",
         "finest_depth", "welded", "inconsistent_edges", "box", "partitioner", "level_maker",
         "representative", "sheets", "weld", "title", "credit", "license", "unit", "digest" })
  {
    EXPECT_TRUE(json.contains(key)) << key;
  }
}
