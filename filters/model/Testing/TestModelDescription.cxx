// SPDX-License-Identifier: BSD-3-Clause
// The description as servers send it.
#include "Testing/Fixtures/Sanitized.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Testing/RandomModels.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>

using namespace kdstream;
using Json = nlohmann::json;

namespace
{

ModelDescription Small()
{
  ModelDescription model = RandomModels(7).Model();
  model.depths = { 2, 6, 7 };
  model.partitions = 4;
  model.grid.bits = 20;
  model.levels.assign(8, ResolutionDescription{ 1, 2, 3, 4, 0.5 });
  model.attributes = { { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 } };
  model.homeView = { { 0, 0, 1 }, { 0, -1, 0 }, true };
  return model;
}

bool Parses(const Json& json)
{
  return ParseModel(json.dump()).HasValue();
}

}

TEST(TestModelDescription, ComesBackBitForBit)
{
  RandomModels random(6);
  for (int i = 0; i < fixtures::Rounds(500); ++i)
  {
    const auto model = random.Model();
    const auto parsed = ParseModel(WriteModel(model));
    ASSERT_TRUE(parsed) << parsed.GetError().message << "\n" << WriteModel(model);
    EXPECT_EQ(*parsed, model);
    for (std::size_t k = 0; k < 3; ++k) // == considers -0 equal to 0
    {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(parsed->box.lo[k]),
        std::bit_cast<std::uint64_t>(model.box.lo[k]));
    }
  }
}

// A server serves exactly the models that clients accept.
TEST(TestModelDescription, IsCheckedAsClientsReadIt)
{
  const auto spoilt = [](auto spoil)
  {
    ModelDescription model = Small();
    spoil(model);
    return model;
  };
  const std::string longest(4096, 'x');
  EXPECT_TRUE(CheckServed(Small()));
  EXPECT_TRUE(CheckServed(spoilt([&](auto& model) { model.description = longest; })));
  for (const ModelDescription& model :
    { spoilt([](auto& m) { m.id = ".hidden"; }), spoilt([](auto& m) { m.digest = "0123"; }),
      spoilt([&](auto& m) { m.title = longest + "x"; }),
      spoilt([&](auto& m) { m.credit = longest + "x"; }),
      spoilt([&](auto& m) { m.license = longest + "x"; }),
      spoilt([&](auto& m) { m.unit = longest + "x"; }),
      spoilt([&](auto& m) { m.description = longest + "x"; }) })
  {
    const auto parsed = ParseModel(WriteModel(model));
    const auto checked = CheckServed(model);
    ASSERT_FALSE(parsed);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.GetError().code, parsed.GetError().code);
    EXPECT_EQ(checked.GetError().message, parsed.GetError().message);
  }
  // Each text alone is allowed, but all of them together are too long.
  ModelDescription model = Small();
  ScalarDescription scalar{ "n", 0, 300, 0, 300, {} };
  for (std::size_t i = 0; i < ScalarDescription::mostClasses; ++i)
  {
    scalar.classes.push_back({ 1 / (3. + static_cast<double>(i)), UINT64_MAX });
  }
  model.scalars = std::vector<ScalarDescription>(200, scalar);
  ASSERT_GT(WriteModel(model).size(), maximumModelBytes);
  EXPECT_EQ(CheckServed(model).GetError().code, ErrorCode::LimitExceeded);
}

TEST(TestModelDescription, UsesTheDocumentedKeys)
{
  const auto json = Json::parse(WriteModel(Small()));
  for (const char* key : { "id", "digest", "vertices", "triangles", "partitions", "box",
         "partition_depth", "stitch_depth", "finest_depth", "precision", "primitive", "levels",
         "original", "title", "credit", "license", "unit", "pose", "attributes" })
  {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(
    json["pose"], (Json{ { "up", { 0, 0, 1 } }, { "view", { 0, -1, 0 } }, { "guessed", true } }));
  EXPECT_EQ(json["levels"][7]["depth"], 7);
  EXPECT_EQ(json["precision"]["bits"], 20);
}

TEST(TestModelDescription, LosslessIsAWord)
{
  auto model = Small();
  model.grid.bits = 0;
  EXPECT_EQ(Json::parse(WriteModel(model))["precision"]["bits"], "lossless");
}

TEST(TestModelDescription, DescriptionsAreOptionalAndShortInLists)
{
  auto model = Small();
  model.description.clear();
  EXPECT_FALSE(Json::parse(WriteModel(model)).contains("description"));
  EXPECT_FALSE(
    Json::parse(WriteModelList({ Summarize(model) }))["models"][0].contains("description"));
  for (int i = 0; i < 399; ++i)
  {
    model.description += 'a';
  }
  const auto listed = [&model] {
    return Json::parse(WriteModelList({ Summarize(model) }))["models"][0].value("description", "");
  };
  EXPECT_EQ(listed(), model.description);
  model.description += "ü and more"; // the second byte of ü would be byte 401
  EXPECT_EQ(listed(), std::string(399, 'a'));
  EXPECT_EQ(Json::parse(WriteModel(model))["description"], model.description);
}

TEST(TestModelDescription, AListNamesItsSite)
{
  EXPECT_FALSE(Json::parse(WriteModelList({})).contains("site"));
  const std::string list = WriteModelList({ Summarize(Small()) }, { "Museum <b>", {} });
  EXPECT_EQ(Json::parse(list)["site"], (Json{ { "title", "Museum <b>" } }));
  EXPECT_EQ(
    Json::parse(WriteModelList({}, { {}, "Bones" }))["site"], (Json{ { "text", "Bones" } }));
  EXPECT_EQ(ParseModelList(list)->size(), 1u) << "older readers ignore it";
}

TEST(TestModelDescription, EveryMemberIsChecked)
{
  const auto good = Json::parse(WriteModel(Small()));
  ASSERT_TRUE(Parses(good));
  const std::pair<const char*, Json> wrong[] = {
    { "/id", "a/b" },
    { "/id", 5 },
    { "/digest", "0123" },
    { "/vertices", 0 },
    { "/vertices", -1 },
    { "/vertices", 1.5 },
    { "/vertices", "7" },
    { "/triangles", 18446744073709551615ull },
    { "/partitions", 5 }, // more than 2^2
    { "/partitions", 0 },
    { "/partition_depth", 31 },
    { "/finest_depth", 1 }, // < P
    { "/stitch_depth", 8 }, // > L
    { "/stitch_depth", 1 }, // < P
    { "/box", nullptr },
    { "/box/lo", Json::array({ 1, 2 }) },
    { "/box/lo/0", "x" },
    { "/box/lo/0", 1.7e308 }, // lower above upper
    { "/precision/bits", 7 },
    { "/precision/bits", 25 },
    { "/precision/bits", "exact" },
    { "/precision/step", 0 },
    { "/precision/step", -1.0 },
    { "/precision/scalar_type", "float16" },
    { "/primitive", "quads" },
    { "/levels", Json::object() },
    { "/levels/3/depth", 4 },
    { "/levels/3/deviation", -0.5 },
    { "/levels/3/deviation_99", -0.5 },
    { "/levels/3/deviation_99", nullptr },
    { "/levels/3/deviation", "0.5" },
    { "/levels/3/spacing", 0 },
    { "/levels/3/spacing", nullptr },
    { "/levels/3/spacing", (1 << 24) + 1 },
    { "/precision/step", nullptr },
    { "/levels/3", 7 },
    { "/original/pieces", "many" },
    { "/title", std::string(5000, 'x') },
    { "/attributes/0/type", "complex" },
    { "/attributes/0/association", "edge" },
    { "/attributes/0/components", 0 },
    { "/pose", 7 },
    { "/pose/guessed", nullptr },
    { "/pose/up", Json::array({ 0, 0, 0 }) },
    { "/pose/up", Json::array({ 0, 2, 0 }) },
    { "/pose/up", Json::array({ 1e200, 0, 0 }) },
    { "/pose/view", Json::array({ 0, 1 }) },
  };
  for (const auto& [place, value] : wrong)
  {
    auto bad = good;
    bad[Json::json_pointer(place)] = value;
    EXPECT_FALSE(Parses(bad)) << place << " = " << value;
  }
  for (const auto& [key, value] : good.items())
  {
    auto bad = good;
    bad.erase(key);
    const bool optional = key == "title" || key == "credit" || key == "license" || key == "unit" ||
                          key == "description" || key == "pose";
    EXPECT_EQ(Parses(bad), optional) << key;
  }
  auto short1 = good;
  short1["levels"].erase(7);
  EXPECT_FALSE(Parses(short1));
  auto more = good;
  more["later"] = { { "deep", 1 } };
  EXPECT_TRUE(Parses(more)) << "unknown members are ignored";
}

TEST(TestModelDescription, ADirectionHasLengthOneWhateverTheVectorsIs)
{
  EXPECT_EQ(DirectionOf({ 0, 0, 7 }), (Vec3{ 0, 0, 1 }));
  EXPECT_EQ(DirectionOf({ 0, -1e-300, 0 }), (Vec3{ 0, -1, 0 }));
  const auto huge = DirectionOf({ 1e308, 1e308, 0 });
  ASSERT_TRUE(huge);
  EXPECT_NEAR((*huge)[0], std::sqrt(0.5), 1e-15);
  const double infinite = std::numeric_limits<double>::infinity();
  const double smallest = std::numeric_limits<double>::denorm_min();
  for (const Vec3& none : { Vec3{}, Vec3{ infinite, 0, 0 }, Vec3{ 0, smallest, 0 } })
  {
    EXPECT_FALSE(DirectionOf(none));
  }
}

TEST(TestModelDescription, NumbersBeyondADoubleAreRefused)
{
  auto text = WriteModel(Small());
  const auto step = text.find("\"step\":");
  ASSERT_NE(step, std::string::npos);
  text.replace(step, text.find_first_of(",}", step) - step, "\"step\":1e999");
  EXPECT_FALSE(ParseModel(text));
}

TEST(TestModelDescription, HostileTextIsRefusedNotObeyed)
{
  EXPECT_FALSE(ParseModel(""));
  EXPECT_FALSE(ParseModel("null"));
  EXPECT_FALSE(ParseModel("[]"));
  EXPECT_FALSE(ParseModel(std::string(maximumModelBytes + 1, ' ')));
  EXPECT_FALSE(ParseModel(std::string(maximumModelBytes, '['))); // depth must not cause recursion
  std::string nested = "{\"id\":" + std::string(200000, '[') + std::string(200000, ']') + "}";
  EXPECT_FALSE(ParseModel(nested));

  RandomModels random(8);
  const auto text = WriteModel(Small());
  int whole = 0;
  for (int i = 0; i < fixtures::Rounds(5000); ++i)
  {
    const auto parsed = ParseModel(random.Mutated(text));
    if (parsed)
    {
      ++whole;
      EXPECT_EQ(*ParseModel(WriteModel(*parsed)), *parsed);
    }
  }
  EXPECT_GT(whole, fixtures::Rounds(20));
}

TEST(TestModelDescription, TextThatIsNotUtf8IsRepaired)
{
  auto model = Small();
  model.title = "bad \xFF\xC0 text";
  const auto parsed = ParseModel(WriteModel(model));
  ASSERT_TRUE(parsed);
  EXPECT_NE(parsed->title, model.title);
}

TEST(TestModelDescription, HalfASurrogatePairIsRefused)
{
  auto text = WriteModel(Small());
  const std::string title = "\"title\":\"";
  text.insert(text.find(title) + title.size(), "\\uDC00");
  const auto parsed = ParseModel(text);
  ASSERT_FALSE(parsed);
  EXPECT_NE(parsed.GetError().message.find("surrogate"), std::string::npos)
    << parsed.GetError().message;
}

TEST(TestModelDescription, ListComesBack)
{
  std::vector<ModelSummary> models;
  RandomModels random(9);
  EXPECT_TRUE(ParseModelList(WriteModelList(models))->empty());
  for (int i = 0; i < 20; ++i)
  {
    models.push_back(Summarize(random.Model()));
  }
  const auto parsed = ParseModelList(WriteModelList(models));
  ASSERT_TRUE(parsed);
  EXPECT_EQ(*parsed, models);
  for (ModelSummary& model : models)
  {
    EXPECT_LE(model.description.size(), mostSummaryBytes);
  }
  EXPECT_FALSE(ParseModelList("{\"models\":[{\"id\":\"..\"}]}"));
  EXPECT_FALSE(ParseModelList("{}"));
  EXPECT_FALSE(ParseModelList("x"));
}

TEST(TestModelDescription, ThePreviewIsLevel11OrTheFinest)
{
  ModelDescription model;
  model.depths.finest = 20;
  EXPECT_EQ(PreviewLevel(model), 11u);
  model.depths.finest = 4;
  EXPECT_EQ(PreviewLevel(model), 4u);
}

TEST(TestModelDescription, WhatServersDoNotSendIsOnlyInTheStore)
{
  ModelDescription model = Small();
  const std::string reported = WriteModel(model);
  model.input = "secret.ply";
  model.inputDigest = std::string(32, 'a'); // whoever has the input can recognise it by this
  model.partitioner = "octree";
  model.welded = 7;
  EXPECT_EQ(WriteModel(model), reported);
}

TEST(TestModelDescription, ModelIds)
{
  for (const auto& id : { std::string("a"), std::string("A.b_c-9"), std::string("a..."),
         std::string("-"), std::string(128, 'x') })
  {
    EXPECT_TRUE(IsModelId(id)) << id;
  }
  for (const auto& id : { std::string(""), std::string("."), std::string(".."),
         std::string(".hidden"), std::string("a/b"), std::string("a b"), std::string("a%20b"),
         std::string("é"), std::string(129, 'x'), std::string("a\0b", 3), std::string("a\\b") })
  {
    EXPECT_FALSE(IsModelId(id)) << id;
  }
}
