// SPDX-License-Identifier: BSD-3-Clause
// Tilesets of 3D Tiles through kdstream-convert and kdstream-build: the content of their finest
// tiles, where it is placed, and which tilesets are refused.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"

#include <nlohmann/json.hpp>

#include <cmath>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::json;

template <class T>
std::string BytesOf(T value)
{
  return { reinterpret_cast<const char*>(&value), sizeof(T) };
}

// A box with the lengths 1, 2 and 3 along x, y and z of glTF, starting at the origin. With z up it
// ends at 1, -3 and 2.
std::string BoxGlb(const std::string& more = "", bool withBatches = false)
{
  GltfBuffer buffer;
  std::vector<float> places;
  for (int i = 0; i < 8; ++i)
  {
    places.insert(places.end(), { float(i % 2), float(2 * (i / 2 % 2)), float(3 * (i / 4)) });
  }
  const std::vector<std::uint16_t> corners{ 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2,
    6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5 };
  const int positions = buffer.Add(places, "VEC3", gltfFloat);
  const int indices = buffer.Add(corners, "SCALAR", gltfUnsignedShort);
  std::string attributes = "\"POSITION\":" + std::to_string(positions);
  if (withBatches)
  {
    attributes +=
      ",\"_BATCHID\":" + std::to_string(buffer.Add(std::vector<float>(8), "SCALAR", gltfFloat));
  }
  const std::string part =
    "\"attributes\":{" + attributes + "},\"indices\":" + std::to_string(indices);
  return buffer.Glb(
    "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
    "\"primitives\":[{" +
    part + "}]}]" + more);
}

std::string B3dm(std::string features, std::string batches, const std::string& glb)
{
  features.resize((features.size() + 7) / 8 * 8, ' ');
  batches.resize((batches.size() + 7) / 8 * 8, ' ');
  std::string file = "b3dm";
  for (const std::size_t number :
    { std::size_t{ 1 }, 28 + features.size() + batches.size() + glb.size(), features.size(),
      std::size_t{ 0 }, batches.size(), std::size_t{ 0 } })
  {
    file += BytesOf(static_cast<std::uint32_t>(number));
  }
  return file + features + batches + glb;
}

std::string SubtreeOf(std::string json, std::string bits)
{
  json.resize((json.size() + 7) / 8 * 8, ' ');
  bits.resize((bits.size() + 7) / 8 * 8, '\0');
  return "subt" + BytesOf(std::uint32_t{ 1 }) + BytesOf(std::uint64_t{ json.size() }) +
         BytesOf(std::uint64_t{ bits.size() }) + json + bits;
}

// Members that each tile must have.
const std::string claims = "\"boundingVolume\":{\"sphere\":[0,0,0,999]},\"geometricError\":1";

std::string At(double x, double y, double z)
{
  return "\"transform\":[1,0,0,0,0,1,0,0,0,0,1,0," + std::to_string(x) + "," + std::to_string(y) +
         "," + std::to_string(z) + ",1]";
}

std::string Content(const std::string& uri)
{
  return "\"content\":{\"uri\":\"" + uri + "\"}";
}

class TestReadTileset : public ConvertTest
{
protected:
  // Writes a tileset. tile: members of the root tile, except `claims`. more: members of the
  // tileset.
  void Tileset(const std::string& name, const std::string& tile, const std::string& asset = "",
    const std::string& more = ",\"geometricError\":1")
  {
    this->WriteText(name, "{\"asset\":{\"version\":\"1.1\"" + asset + "}" + more + ",\"root\":{" +
                            claims + "," + tile + "}}");
  }
  void Folders(const std::string& name) { fs::create_directories(this->Folder / name); }

  void Expect(std::size_t boxes, const Vec3& lo, const Vec3& hi, const std::string& warnings = "")
  {
    std::string lines;
    if (!warnings.empty())
    {
      lines = "kdstream-convert: warning: tileset.json: " + warnings + "\n";
    }
    const Mesh mesh = this->Converted("tileset.json", lines);
    EXPECT_EQ(mesh.triangles.size(), 12 * boxes);
    const Box box = BoxOf(mesh);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_NEAR(box.lo[k], lo[k], 1e-6) << k;
      EXPECT_NEAR(box.hi[k], hi[k], 1e-6) << k;
    }
    EXPECT_NEAR(VolumeOf(mesh), 6.0 * double(boxes), 1e-4);
  }
  // Expects an error for a tileset whose root tile has these members.
  void ExpectTileError(const std::string& tile, const std::string& what)
  {
    this->Tileset("tileset.json", tile);
    this->ExpectError("tileset.json", what);
  }

  Json Info(const std::string& store)
  {
    return Json::parse(RunTool(this->Folder, "store", { "info", store, "--json" }).out);
  }
  void Make(const std::string& store, const std::vector<std::string>& arguments)
  {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), { "-o", store, "--quiet", "--up", "0,0,1" });
    const Outcome built = this->Build(all);
    ASSERT_EQ(built.exitCode, 0) << built.err;
  }
  void Export(
    const std::string& store, const std::string& folder, std::vector<std::string> more = {})
  {
    more.insert(more.begin(), { "export", store, folder, "--format", "3dtiles", "--quiet" });
    const Outcome exported = RunTool(this->Folder, "store", more);
    ASSERT_EQ(exported.exitCode, 0) << exported.err;
  }
};

}

TEST_F(TestReadTileset, WhatWasExportedComesBack)
{
  const Mesh ball = DisplacedSphere(6, { 40, -20, 8 });
  ASSERT_TRUE(WriteMesh(this->Folder / "ball.ply", ball));
  this->Make("ball.kds", { "ball.ply", "--vertices-per-partition", "500", "--cell-vertices", "1" });
  const Json before = this->Info("ball.kds");
  std::vector<std::string> compressions{ "none" };
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
  compressions.emplace_back("meshopt");
#endif
#ifdef KDSTREAM_HAS_DRACO
  compressions.emplace_back("draco");
#endif
  for (const std::string& compression : compressions)
  {
    this->Export("ball.kds", compression, { "--compression", compression });
    this->Make(compression + ".kds", { compression + "/tileset.json" });
    const Json after = this->Info(compression + ".kds");
    EXPECT_EQ(after["triangles"], before["triangles"]) << compression;
    EXPECT_EQ(after["vertices"], before["vertices"]) << "tiles meet: " << compression;
    const Outcome converted = this->Convert(compression + "/tileset.json");
    EXPECT_EQ(converted.exitCode, 0);
    EXPECT_NE(converted.err.find("which only close gaps between tiles"), std::string::npos)
      << converted.err;
    const Mesh back = this->Read("out.ply");
    EXPECT_NEAR(VolumeOf(back), VolumeOf(ball), std::abs(VolumeOf(ball)) * 1e-4) << compression;
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_NEAR(BoxOf(back).lo[k], BoxOf(ball).lo[k], 1e-4);
      EXPECT_NEAR(BoxOf(back).hi[k], BoxOf(ball).hi[k], 1e-4);
    }
    EXPECT_EQ(back.scalarType, ScalarType::Float32);
  }
}

TEST_F(TestReadTileset, ArraysKeepTheirNames)
{
  Mesh ring = Torus(40, 20);
  Attribute heat;
  heat.name = "heat of the day";
  heat.type = AttributeType::Float32;
  heat.association = AttributeAssociation::Point;
  heat.components = 1;
  heat.values.resize(ring.points.size() * heat.TupleSize());
  for (std::size_t i = 0; i < ring.points.size(); ++i)
  {
    heat.Set(i, 0, double(float(ring.points[i][0])));
  }
  ring.attributes.push_back(heat);
  ASSERT_TRUE(WriteMesh(this->Folder / "ring.ply", ring));
  this->Make(
    "ring.kds", { "ring.ply", "--vertices-per-partition", "100", "--precision", "lossless" });
  for (const std::string compression : { "none", "draco" })
  {
    this->Export("ring.kds", compression, { "--compression", compression });
    ASSERT_EQ(this->Convert(compression + "/tileset.json").exitCode, 0);
    auto reader = MeshReader::Open(this->Folder / "out.ply");
    ASSERT_TRUE(reader);
    Mesh back;
    ASSERT_TRUE((*reader)->ReadRest(back, {}));
    const std::vector<double> values = ValuesOf(back, "heat of the day");
    ASSERT_EQ(values.size(), back.points.size());
    for (std::size_t i = 0; i < values.size(); ++i)
    {
      ASSERT_NEAR(values[i], back.points[i][0], 1e-3) << compression;
    }
  }
}

TEST_F(TestReadTileset, PicturesComeWithTheTiles)
{
  const Outcome made = RunTool(this->Folder, "generate",
    { "statue", "statue.obj", "--vertices", "4000", "--picture-side", "128", "--quiet" });
  ASSERT_EQ(made.exitCode, 0) << made.err;
  this->Make(
    "statue.kds", { "statue.obj", "--textures", "tiles", "--vertices-per-partition", "500" });
  this->Export("statue.kds", "tiles");
  this->Make("back.kds", { "tiles/tileset.json", "--textures", "tiles" });
  const Json before = this->Info("statue.kds"), after = this->Info("back.kds");
  EXPECT_EQ(after["triangles"], before["triangles"]);
  EXPECT_TRUE(before.contains("tiles") && after.contains("tiles")) << after;
}

TEST_F(TestReadTileset, TransformsUpAxesAndExternalTilesets)
{
  this->Folders("far/deep");
  this->WriteText("box.glb", BoxGlb());
  this->Tileset("tileset.json", Content("box.glb"));
  this->Expect(1, { 0, -3, 0 }, { 1, 0, 2 });
  for (const auto& [axis, lo, hi] : { std::tuple{ "Z", Vec3{ 0, 0, 0 }, Vec3{ 1, 2, 3 } },
         { "X", Vec3{ -3, 0, 0 }, Vec3{ 0, 2, 1 } }, { "Y", Vec3{ 0, -3, 0 }, Vec3{ 1, 0, 2 } } })
  {
    this->Tileset(
      "tileset.json", Content("box.glb"), ",\"gltfUpAxis\":\"" + std::string(axis) + "\"");
    this->Expect(1, lo, hi);
  }
  // The tiles below replace the whole root tile. They are in another tileset, which refers to a
  // file in a folder above it.
  this->Tileset("tileset.json", At(10, 0, 0) + "," + Content("missing.glb") + ",\"children\":[{" +
                                  claims + "," + At(0, 100, 0) + "," +
                                  Content("far/deep/more.json?v=1") + "}]");
  this->Tileset("far/deep/more.json", At(0, 0, 1000) + "," + Content("../../box.glb"));
  this->ExpectError("tileset.json", "tile root names \"missing.glb\", which is not there");
  this->WriteText("missing.glb", BoxGlb());
  this->Expect(1, { 10, 97, 1000 }, { 11, 100, 1002 });
  this->Tileset("tileset.json", "\"refine\":\"ADD\",\"contents\":[{\"uri\":\"box.glb\"},{\"uri\":"
                                "\"./box%2Eglb\"}],\"children\":[{" +
                                  claims + "," + At(0, 100, 0) + "," + Content("box.glb") + "}]");
  this->Expect(3, { 0, -3, 0 }, { 1, 100, 2 });
}

TEST_F(TestReadTileset, TilesOfVersionOne)
{
  this->WriteText("a.b3dm", B3dm("{\"BATCH_LENGTH\":2,\"RTC_CENTER\":[100,200,300]}",
                              "{\"height\":[1,2],\"name\":[\"a\",\"b\"]}", BoxGlb("", true)));
  this->Tileset("tileset.json", "\"content\":{\"url\":\"a.b3dm\"}");
  this->Expect(1, { 100, 197, 300 }, { 101, 200, 302 },
    "tile \"a.b3dm\": its batch table is left out: \"height\", \"name\"");

  // The tile's centre as floats, and the glTF's own centre, which is in the tileset's axes, too.
  const std::string center = BytesOf(1.0F) + BytesOf(2.0F) + BytesOf(3.0F) + "    ";
  std::string features = "{\"BATCH_LENGTH\":0,\"RTC_CENTER\":{\"byteOffset\":0}}";
  features.resize((features.size() + 7) / 8 * 8, ' ');
  const std::string glb =
    BoxGlb(",\"extensionsUsed\":[\"CESIUM_RTC\"],\"extensions\":{\"CESIUM_RTC\":"
           "{\"center\":[10,20,30]}}");
  std::string file = "b3dm";
  for (const std::size_t number : { std::size_t{ 1 }, 28 + features.size() + 16 + glb.size(),
         features.size(), std::size_t{ 16 }, std::size_t{ 0 }, std::size_t{ 0 } })
  {
    file += BytesOf(static_cast<std::uint32_t>(number));
  }
  this->WriteText("a.b3dm", file + features + center + glb);
  this->Expect(1, { 11, 19, 33 }, { 12, 22, 35 });

  const std::string inner = B3dm("{\"BATCH_LENGTH\":0}", "", BoxGlb());
  const std::string points = "pnts" + BytesOf(std::uint32_t{ 1 }) + BytesOf(std::uint32_t{ 16 }) +
                             BytesOf(std::uint32_t{ 0 });
  this->WriteText("a.cmpt", "cmpt" + BytesOf(std::uint32_t{ 1 }) +
                              BytesOf(static_cast<std::uint32_t>(16 + 2 * inner.size() + 16)) +
                              BytesOf(std::uint32_t{ 3 }) + inner + points + inner);
  this->Tileset("tileset.json", Content("a.cmpt"));
  this->Expect(
    2, { 0, -3, 0 }, { 1, 0, 2 }, "tile \"a.cmpt\": left out: tiles of the unsupported kind pnts");
}

TEST_F(TestReadTileset, ImplicitTiling)
{
  this->Folders("c/1");
  this->Folders("s");
  this->WriteText("c/0-0-0.glb", BoxGlb());
  for (const std::string name :
    { "c/1-0-0.glb", "c/1-1-0.glb", "c/1-0-1.glb", "c/1-1-1.glb", "c/2-3-1.glb" })
  {
    this->WriteText(name, BoxGlb());
  }
  // A subtree of two levels: the root, and all but the second of its four tiles. On the third level
  // there is nothing below the tile (1, 1), and one tile below (1, 0).
  const auto subtree = [](const std::string& tiles, const std::string& contents,
                         const std::string& children, const char* named)
  {
    std::string json = "{\"buffers\":[{\"byteLength\":24}],\"bufferViews\":[";
    for (const int at : { 0, 8, 16 })
    {
      json += std::string(at > 0 ? "," : "") +
              "{\"buffer\":0,\"byteOffset\":" + std::to_string(at) + ",\"byteLength\":8}";
    }
    const std::string view = std::string("{\"") + named + "\":";
    json += "],\"tileAvailability\":" + view + "0},\"contentAvailability\":[" + view +
            "1}],\"childSubtreeAvailability\":" + view + "2}}";
    std::string bits;
    for (std::string each : { tiles, contents, children })
    {
      each.resize(8, '\0');
      bits += each;
    }
    return SubtreeOf(json, bits);
  };
  const std::string scheme = "\"subdivisionScheme\":\"QUADTREE\",\"subtreeLevels\":2,"
                             "\"subtrees\":{\"uri\":\"s/{level}-{x}-{y}\"},";
  const std::string contents = Content("c/{level}-{x}-{y}.glb");
  this->WriteText("s/0-0-0", subtree("\x1f", "\x1b", std::string(1, '\0'), "bitstream"));
  this->Tileset(
    "tileset.json", contents + ",\"implicitTiling\":{" + scheme + "\"availableLevels\":2}");
  // The bits 0, 1, 3, 4: the root, which is replaced, and the tiles (0, 0), (0, 1), (1, 1).
  fs::remove(this->Folder / "c/1-1-0.glb");
  this->Expect(3, { 0, -3, 0 }, { 1, 0, 2 });
  this->Tileset("tileset.json",
    contents + ",\"refine\":\"ADD\",\"implicitTiling\":{" + scheme + "\"availableLevels\":2}");
  this->Expect(4, { 0, -3, 0 }, { 1, 0, 2 });

  // Below (1, 0), which has Morton index 1 among the four tiles: the tile (3, 1), which has index 3
  // among its four.
  this->WriteText("s/0-0-0", subtree("\x1f", "\x1f", std::string(1, '\x80'), "bufferView"));
  this->WriteText("c/1-1-0.glb", "this one is replaced");
  this->WriteText("s/2-3-1", subtree("\x01", "\x01", std::string(1, '\0'), "bufferView"));
  this->Tileset("tileset.json",
    contents + ",\"extensions\":{\"3DTILES_implicit_tiling\":{" + scheme + "\"maximumLevel\":2}}");
  this->Expect(4, { 0, -3, 0 }, { 1, 0, 2 });

  // All tiles of an octree, and a content that does not exist.
  this->WriteText("s/0-0-0", "{\"tileAvailability\":{\"constant\":1},\"contentAvailability\":[{"
                             "\"constant\":1}],\"childSubtreeAvailability\":{\"constant\":0}}");
  const std::string octree =
    "\"implicitTiling\":{\"subdivisionScheme\":\"OCTREE\",\"subtreeLevels\":2,"
    "\"subtrees\":{\"uri\":\"s/{level}-{x}-{y}\"},\"availableLevels\":2}";
  this->Tileset("tileset.json", Content("c/{level}/{x}{y}{z}.glb") + "," + octree);
  for (const std::string name : { "000", "100", "010", "110", "001", "101", "011" })
  {
    this->WriteText("c/1/" + name + ".glb", BoxGlb());
  }
  this->ExpectError("tileset.json", "tile root names \"c/1/111.glb\", which is not there");
  this->WriteText("c/1/111.glb", BoxGlb());
  this->Expect(8, { 0, -3, 0 }, { 1, 0, 2 });
}

TEST_F(TestReadTileset, OnTheGlobeCoordinatesAreDoubles)
{
  this->WriteText("box.glb", BoxGlb());
  this->Tileset("tileset.json", At(4180000.125, 968000, 4702000) + "," + Content("box.glb"));
  this->Expect(1, { 4180000.125, 967997, 4702000 }, { 4180001.125, 968000, 4702002 },
    "its coordinates are relative to the centre of the earth (ECEF): kdstream-build --up "
    "0.6543,0.1515,0.7409 sets it upright");
  EXPECT_EQ(this->Read("out.ply").scalarType, ScalarType::Float64);
}

TEST_F(TestReadTileset, HostileTilesetsAreNamed)
{
  this->Folders("in");
  this->Folders("set");
  this->WriteText("box.glb", BoxGlb());
  this->WriteText("in/box.glb", BoxGlb());
  fs::create_symlink("../box.glb", this->Folder / "in/link.glb");
  // Names that lead out of the folder.
  const auto inFolder = [&](const std::string& tile, const std::string& what)
  {
    this->Tileset("in/tileset.json", tile);
    this->ExpectError("in/tileset.json", what);
  };
  const std::string outside = "which is outside the tileset's folder, and nothing is read there";
  inFolder(Content("../box.glb"), "tile root names \"../box.glb\", " + outside);
  inFolder(Content("%2e%2e/box.glb"), outside);
  inFolder(Content("/etc/passwd"), "tile root names \"/etc/passwd\", " + outside);
  inFolder(Content("x/../../box.glb"), outside);
  inFolder(Content("link.glb"), "which is a link that leads out of the tileset's folder");
  for (const std::string address :
    { "https://example.org/a.glb", "data:,glTF", "file:///etc/passwd", "C:/a.glb" })
  {
    inFolder(Content(address), "which is a web address, and nothing is downloaded");
  }
  inFolder(Content("none.glb"), "which is not there");
  inFolder("\"children\":[{" + claims + "},{" + claims + ",\"children\":[{" + claims + "," +
             Content("none.glb") + "}]}]",
    "tile root/1/0 names \"none.glb\"");
  // Loops, and depth.
  this->ExpectTileError(
    Content("tileset.json"), "contains itself, directly or through another tileset");
  this->Tileset("a.json", Content("b.json"));
  this->Tileset("b.json", Content("a.json"));
  this->ExpectTileError(Content("a.json"), "tileset \"a.json\": contains itself");
  std::string deep, ends;
  for (int i = 0; i < 600; ++i)
  {
    deep += (i > 0 ? "," : "") + std::string("\"children\":[{") + claims;
    ends += "}]";
  }
  this->ExpectTileError(deep + ends, "is nested in 512 others; this is the maximum");
  // Claims that are impossible.
  for (const std::string claim : { "\"boundingVolume\":{\"box\":[1,2]},\"geometricError\":1",
         "\"boundingVolume\":{\"sphere\":[0,0,0,-1]},\"geometricError\":1",
         "\"boundingVolume\":{\"region\":[0,1,0,-1,0,0]},\"geometricError\":1",
         "\"geometricError\":1" })
  {
    this->ExpectTileError(
      "\"children\":[{" + claim + "}]", "tile root/0 has an invalid boundingVolume");
  }
  for (const std::string error : { "-1", "\"x\"", "null" })
  {
    this->ExpectTileError(
      "\"children\":[{\"boundingVolume\":{\"sphere\":[0,0,0,9]},\"geometricError\":" + error + "}]",
      "tile root/0 has a geometricError that is not 0 or more");
  }
  this->ExpectTileError("\"transform\":[1,2,3]", "has a transform that does not have 16 numbers");
  this->ExpectTileError(
    "\"transform\":[1,0,0,5,0,1,0,0,0,0,1,0,0,0,0,1]", "whose last row is not 0 0 0 1");
  this->ExpectTileError("\"refine\":\"PERHAPS\"", "has an unknown refinement");
  this->ExpectTileError(
    "\"transform\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]", "has a transform that leaves it no volume");
  this->ExpectTileError("\"children\":{\"0\":{}}", "tile root has children that are not a list");
  this->ExpectTileError("\"content\":{\"uri\":\"box.glb\",\"boundingVolume\":{\"box\":[]}}",
    "tile root has an invalid boundingVolume");
  for (const auto& [more, what] : { std::pair{ ",\"geometricError\":-1", "has a geometricError" },
         { ",\"geometricError\":\"1\"", "has a geometricError" },
         { ",\"extensionsRequired\":[\"VENDOR_x\"]", "needs the extension \"VENDOR_x\"" } })
  {
    this->Tileset("tileset.json", Content("box.glb"), "", more);
    this->ExpectError("tileset.json", what);
  }
  this->WriteText("tileset.json",
    "{\"asset\":{\"version\":\"2.0\"},\"root\":{" + claims + "," + Content("box.glb") + "}}");
  this->ExpectError("tileset.json", "is a tileset of version \"2.0\"");
  this->Tileset("tileset.json", Content("box.glb") +
                                  ",\"children\":[{\"boundingVolume\":{\"sphere\":"
                                  "[0,0,0,9]},\"geometricError\":5}]");
  this->Expect(
    1, { 0, -3, 0 }, { 1, 0, 2 }, "1 tile claims a larger geometricError than the tile above");
  // Numbers in implicit tiling.
  const auto implicit = [](int levels, int ofSubtree)
  {
    return "\"implicitTiling\":{\"subdivisionScheme\":\"OCTREE\",\"subtreeLevels\":" +
           std::to_string(ofSubtree) +
           ",\"subtrees\":{\"uri\":\"s.json\"},\"availableLevels\":" + std::to_string(levels) + "}";
  };
  this->ExpectTileError(implicit(60, 3), "has implicitTiling of more than 32 levels");
  this->ExpectTileError(
    implicit(32, 32), "has implicitTiling of more than 1048576 tiles a subtree");
  this->ExpectTileError(implicit(0, 1), "has implicitTiling without a subdivisionScheme");
  this->WriteText("s.json", "{\"tileAvailability\":{\"constant\":1},\"contentAvailability\":[],"
                            "\"childSubtreeAvailability\":{\"constant\":1}}");
  this->ExpectTileError(implicit(32, 3), "has more than 1048576 tiles");
  this->WriteText("s.json", "{\"buffers\":[{\"byteLength\":1}],\"bufferViews\":[{\"buffer\":0,"
                            "\"byteLength\":1}],\"tileAvailability\":{\"bitstream\":0}}");
  this->ExpectTileError(
    implicit(3, 3), "has a subtree \"s.json\" that has no 73 bits in its bufferView 0");
}

// Data that cannot be carried over, and data that is not where a tileset says it is.
TEST_F(TestReadTileset, WhatIsLostIsNamed)
{
  this->WriteText("box.glb", BoxGlb());
  this->Tileset("tileset.json", "\"metadata\":{\"class\":\"c\"}," + Content("box.glb"), "",
    ",\"schema\":{\"id\":\"s\"}");
  this->Expect(1, { 0, -3, 0 }, { 1, 0, 2 },
    "members of tilesets that are left out: \"metadata\", \"schema\"");
  this->Tileset("tileset.json", Content("box.glb"), "", ",\"extensionsUsed\":[\"VENDOR_x\"]");
  this->Expect(1, { 0, -3, 0 }, { 1, 0, 2 }, "extensions that are not read: \"VENDOR_x\"");
  const std::string out = "tile \"box.glb\": it reaches out of its boundingVolume, beyond which "
                          "viewers do not look for it";
  for (const auto& [volume, isWarned] :
    { std::pair{ "\"box\":[90,0,0,1,0,0,0,9,0,0,0,9]", true }, { "\"sphere\":[0,0,0,2]", true },
      { "\"box\":[0,0,0,-4,0,0,0,0,4,0,4,0]", false }, { "\"region\":[0,0,0.1,0.1,0,9]", false } })
  {
    this->WriteText("tileset.json",
      "{\"asset\":{\"version\":\"1.1\"},\"root\":{\"boundingVolume\":{" + std::string(volume) +
        "},\"geometricError\":1," + At(10, 0, 0) + "," + Content("box.glb") + "}}");
    this->Expect(1, { 10, -3, 0 }, { 11, 0, 2 }, isWarned ? out : "");
  }
  this->WriteText("box.glb", BoxGlb(",\"cameras\":[{\"type\":\"perspective\"}]"));
  this->Tileset("tileset.json", Content("box.glb"));
  this->Expect(1, { 0, -3, 0 }, { 1, 0, 2 }, "tile \"box.glb\": left out: 1 camera");
}

TEST_F(TestReadTileset, DamagedTilesAreNamed)
{
  const std::string whole = B3dm("{\"BATCH_LENGTH\":0}", "", BoxGlb());
  this->Tileset("tileset.json", Content("a.b3dm"));
  for (const std::size_t size : { std::size_t{ 10 }, std::size_t{ 40 }, whole.size() - 1 })
  {
    this->WriteText("a.b3dm", whole.substr(0, size));
    this->ExpectError("tileset.json", "tile \"a.b3dm\": ");
  }
  std::string wrong = whole;
  wrong.replace(12, 4, BytesOf(std::uint32_t{ 0xFFFFFFFF }));
  this->WriteText("a.b3dm", wrong);
  this->ExpectError("tileset.json", "tile \"a.b3dm\": claims tables of ");
  wrong = whole;
  wrong[4] = 2;
  this->WriteText("a.b3dm", wrong);
  this->ExpectError("tileset.json", "tile \"a.b3dm\": has version 2 of its format");
  this->WriteText("a.b3dm", "\x1f\x8b\x08 packed");
  this->ExpectError("tileset.json", "tile \"a.b3dm\": is compressed by gzip");
  std::string composite = "cmpt" + BytesOf(std::uint32_t{ 1 }) + BytesOf(std::uint32_t{ 28 }) +
                          BytesOf(std::uint32_t{ 0xFFFFFFFF }) + "b3dm" +
                          BytesOf(std::uint32_t{ 1 }) + BytesOf(std::uint32_t{ 0 });
  this->WriteText("a.b3dm", composite);
  this->ExpectError("tileset.json", "but has no room for tile 0");
  this->WriteText("tileset.json", "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\"");
  this->ExpectError("tileset.json", "its JSON breaks off");
  this->WriteText("tileset.json", "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1}");
  this->ExpectError("tileset.json", "is not a tileset of 3D Tiles: its JSON has no root");
  this->WriteText("tileset.json", "{\"type\":\"CityJSON\"}");
  this->ExpectError("tileset.json", "is a JSON file that is neither glTF nor a tileset");
}
