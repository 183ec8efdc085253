// SPDX-License-Identifier: BSD-3-Clause
// Textured models through kdstream-build and kdstream-store extract: the output is the same as the
// input.
#include "Testing/EndToEnd/Textures/SameTextures.h"
#include "Testing/EndToEnd/Textures/TexturedFiles.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/Builder.h"
#include "filters/codec/TextureTile.h"
#include "filters/model/JsonReader.h"
#include "filters/store/Store.h"
#include "filters/texture/BakeTextures.h"

#include <algorithm>
#include <map>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestTexturedExtract : public TexturedTest
{
protected:
  void BuildAndExtract(
    const std::string& input, const std::string& output, const std::vector<std::string>& more)
  {
    std::vector<std::string> arguments{ input, "-o", "m.kds", "--quiet", "--precision", "lossless",
      "--vertices-per-partition", "100" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = this->Build(arguments);
    ASSERT_EQ(built.exitCode, 0) << built.err;
    const Outcome verified = this->Store({ "verify", "m.kds" });
    EXPECT_EQ(verified.exitCode, 0) << verified.err;
    const Outcome extracted = this->Store({ "extract", "m.kds", "--all", "-o", output, "--quiet" });
    ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
    EXPECT_EQ(extracted.err, "");
  }
  // Levels beyond 11 have several pieces.
  void BuildStatue()
  {
    ASSERT_EQ(
      RunTool(this->Folder, "generate",
        { "statue", "statue.obj", "--vertices", "12000", "--picture-side", "256", "--quiet" })
        .exitCode,
      0);
    this->BuildAndExtract("statue.obj", "all.obj", { "--cell-vertices", "2" });
  }
};

}

TEST_F(TestTexturedExtract, LosslessModelsComeBack)
{
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    this->WriteHardObj("hard", seed);
    this->BuildAndExtract("hard.obj", "out.obj", { "--texture-quality", "lossless" });
    ExpectSameTextures(this->ReadWithTextures("hard.obj"), this->ReadWithTextures("out.obj"));
  }
}

TEST_F(TestTexturedExtract, PhotographsComeBack)
{
  ASSERT_EQ(RunTool(this->Folder, "generate",
              { "statue", "statue.obj", "--vertices", "3000", "--picture-side", "256", "--quiet" })
              .exitCode,
    0);
  this->BuildAndExtract("statue.obj", "out.obj", { "--texture-quality", "lossless" });
  ExpectSameTextures(this->ReadWithTextures("statue.obj"), this->ReadWithTextures("out.obj"));
}

// Each place is compared with the result of kdstream-convert, because coordinates are flipped, and
// therefore rounded.
TEST_F(TestTexturedExtract, AGlbHasTheSameColours)
{
  this->WriteHardObj("hard", 1);
  this->BuildAndExtract(
    "hard.obj", "out.glb", { "--texture-quality", "lossless", "--up", "0,1,0" });
  const auto colorsOf = [&](const std::string& input)
  {
    EXPECT_EQ(
      RunTool(this->Folder, "convert", { input, "-o", "baked.ply", "--quiet" }).exitCode, 0);
    const Mesh mesh = this->Read("baked.ply");
    std::map<Vec3, std::array<double, 3>> colors;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
    {
      const Attribute& rgb = mesh.attributes.back();
      const Vec3& place = mesh.points[v]; // rounded, because a .glb has floats
      colors[{ std::round(1e5 * place[0]), std::round(1e5 * place[1]),
        std::round(1e5 * place[2]) }] = { rgb.Get(v, 0), rgb.Get(v, 1), rgb.Get(v, 2) };
    }
    return colors;
  };
  const auto before = colorsOf("hard.obj"), after = colorsOf("out.glb");
  ASSERT_EQ(before.size(), after.size());
  for (const auto& [place, color] : before)
  {
    ASSERT_TRUE(after.contains(place)) << place[0] << " " << place[1];
    for (std::size_t k = 0; k < 3; ++k)
    {
      ASSERT_NEAR(after.at(place)[k], color[k], 4);
    }
  }
}

TEST_F(TestTexturedExtract, PartsHaveTheirPictures)
{
  this->WriteHardObj("hard", 2);
  this->BuildAndExtract("hard.obj", "all.obj", {});
  for (const std::vector<std::string>& what :
    { std::vector<std::string>{ "--partition", "2" }, { "--region", "9", "--rings", "0" } })
  {
    for (const char* output : { "part.obj", "part.glb" })
    {
      std::vector<std::string> arguments{ "extract", "m.kds", "-o", output };
      arguments.insert(arguments.end(), what.begin(), what.end());
      const Outcome extracted = this->Store(arguments);
      EXPECT_EQ(extracted.exitCode, 0) << extracted.err;
      EXPECT_NE(extracted.err.find("triangles and "), std::string::npos) << extracted.err;
    }
    const TexturedMesh part = this->ReadWithTextures("part.obj");
    EXPECT_EQ(PicturesOf(part).size(), part.pictures.size());
    EXPECT_GT(part.mesh.triangles.size(), 100U);
  }
  EXPECT_TRUE(this->Files().contains("part-partition-2.png"));
}

// Each triangle occurs once; the colours of vertices are the means of what the pictures show.
TEST_F(TestTexturedExtract, LevelsHaveTheirPictures)
{
  this->BuildStatue();
  const auto store = kdstream::Store::Open(this->Folder / "m.kds");
  ASSERT_TRUE(store);
  const ModelDescription& model = (*store)->Info();
  const std::size_t pictures = model.levels.back().pieces;
  ASSERT_GT(pictures, 1U);
  const std::string level = std::to_string(model.depths.finest);
  for (const char* const name : { "level.ply", "level.glb", "level.obj" })
  {
    const Outcome extracted =
      this->Store({ "extract", "m.kds", "--level", level, "-o", name, "--quiet" });
    ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
    EXPECT_EQ(extracted.err, "");
  }
  const Mesh plain = this->Read("level.ply");
  TexturedMesh textured = this->ReadWithTextures("level.obj");
  EXPECT_EQ(textured.mesh.triangles.size(), plain.triangles.size());
  EXPECT_EQ(textured.pictures.size(), pictures);
  EXPECT_NE(ReadWhole(this->Folder / "level.glb").find("\"level-" + level), std::string::npos);
  ASSERT_TRUE(BakeTextures(textured));
  const auto colorsOf = [](const Mesh& mesh)
  {
    std::map<Vec3, std::array<double, 3>> colors;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
    {
      const Attribute& rgb = mesh.attributes.back();
      colors[mesh.points[v]] = { rgb.Get(v, 0), rgb.Get(v, 1), rgb.Get(v, 2) };
    }
    return colors;
  };
  const auto expected = colorsOf(plain), found = colorsOf(textured.mesh);
  ASSERT_EQ(expected.size(), found.size());
  double off = 0, elsewhere = 0;
  auto last = expected.rbegin()->second;
  for (const auto& [place, color] : expected)
  {
    ASSERT_TRUE(found.contains(place));
    off += std::abs(color[1] - found.at(place)[1]);
    elsewhere += std::abs(color[1] - last[1]);
    last = color;
  }
  EXPECT_LT(off, elsewhere / 2) << elsewhere / double(expected.size());
}

TEST_F(TestTexturedExtract, TilesOfTilesetsHaveTheirPictures)
{
  this->BuildStatue();
  const Outcome exported =
    this->Store({ "export", "m.kds", "tiles", "--format", "3dtiles", "--quiet" });
  ASSERT_EQ(exported.exitCode, 0) << exported.err;
  std::size_t tiles = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(this->Folder / "tiles"))
  {
    if (entry.path().extension() == ".glb")
    {
      ++tiles;
      const std::string bytes = ReadWhole(entry.path());
      EXPECT_NE(bytes.find("EXT_texture_webp"), std::string::npos) << entry.path();
      EXPECT_EQ(bytes.find("COLOR_0"), std::string::npos) << entry.path();
    }
  }
  EXPECT_GT(tiles, 10U);
}

TEST_F(TestTexturedExtract, ASmallFileOfOnePieceHasItsPicture)
{
  this->BuildStatue();
  const auto store = kdstream::Store::Open(this->Folder / "m.kds");
  ASSERT_TRUE(store);
  const unsigned finest = (*store)->Info().depths.finest;
  for (const unsigned level : { 11U, finest })
  {
    const Outcome exported = this->Store({ "export", "m.kds", "level.glb", "--format", "glb",
      "--level", std::to_string(level), "--quiet" });
    ASSERT_EQ(exported.exitCode, 0) << exported.err;
    const bool isOne = (*store)->Info().levels[level].pieces == 1;
    EXPECT_EQ(isOne, level == 11);
    EXPECT_EQ(
      ReadWhole(this->Folder / "level.glb").find("EXT_texture_webp") != std::string::npos, isOne);
    EXPECT_EQ(exported.err.find("the level's textures are left out") == std::string::npos, isOne);
  }
}

// Tiles with a correct checksum whose image is not an image, or has another size.
class WrongImages : public PieceTextures
{
public:
  explicit WrongImages(std::vector<std::uint8_t> image)
    : Image(std::move(image))
  {
  }
  TextureDescription Describe() const override { return {}; }
  Result<EncodedTexture> Make(Piece& piece) const override
  {
    TextureTile tile{ 9, 9, TileImage::Webp, this->Image, {} };
    tile.corners.resize(piece.triangles.size());
    return EncodedTexture{ EncodeTextureTile(tile, piece.triangles), 81 };
  }

private:
  std::vector<std::uint8_t> Image;
};

TEST_F(TestTexturedExtract, WrongImagesAreNamed)
{
  const std::vector<std::uint8_t> small =
    EncodePicture({ 2, 2, 1, { 1, 2, 3, 4 } }, PictureType::Png);
  for (const auto& [image, what] :
    { std::pair{ small, "its image does not have the size that the tile states" },
      { std::vector<std::uint8_t>{ 1, 2 }, "it is neither JPEG, PNG nor WebP" },
      { std::vector<std::uint8_t>(small.begin(), small.end() - 20),
        "it is a damaged or truncated PNG (it ends too early)" } })
  {
    BuildOptions options;
    options.textures = std::make_shared<WrongImages>(image);
    ASSERT_TRUE(BuildStore(DisplacedSphere(3), "s.ply", this->Folder / "m.kds", options));
    this->ExpectError(this->Store({ "extract", "m.kds", "--all", "-o", "out.glb" }), 1,
      std::string("kdstream-store: error: m.kds: textures/0: ") + what);
    EXPECT_FALSE(this->Files().contains("out.glb"));
  }
}

TEST_F(TestTexturedExtract, ExportedFoldersHaveTheTextures)
{
  this->WriteHardObj("hard", 2);
  this->BuildAndExtract("hard.obj", "all.obj", {});
  const Outcome exported = this->Store({ "export", "m.kds", "www", "--quiet" });
  ASSERT_EQ(exported.exitCode, 0) << exported.err;
  const auto store = kdstream::Store::Open(this->Folder / "m.kds");
  ASSERT_TRUE(store);
  const ModelDescription& info = (*store)->Info();
  for (std::uint32_t p = 0; p < info.partitions; ++p)
  {
    const auto blob = (*store)->Read(protocol::BlobId::Texture(p));
    ASSERT_TRUE(blob);
    EXPECT_EQ(ReadWhole(this->Folder /
                        ("www/api/models/m/" + info.digest + "/textures/" + std::to_string(p))),
      std::string(blob->begin(), blob->end()));
  }
  const auto blob = (*store)->Read(protocol::BlobId::LevelTexture(0, 1));
  ASSERT_TRUE(blob);
  EXPECT_EQ(ReadWhole(this->Folder / ("www/api/models/m/" + info.digest + "/level-textures/0/1")),
    std::string(blob->begin(), blob->end()));
  EXPECT_NE(ReadWhole(this->Folder / "www/api/models/m/model.json").find("\"textures\":{\"bytes\""),
    std::string::npos);
}

TEST_F(TestTexturedExtract, LevelsAndPlainModelsAreGlbToo)
{
  this->WriteHardObj("hard", 3);
  this->BuildAndExtract("hard.obj", "all.obj", {});
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--level", "4", "-o", "level.glb" }).exitCode, 0);
  const Outcome built = this->Build({ "level.glb", "-o", "level.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_NE(this->Store({ "info", "level.kds" }).out.find("RGB"), std::string::npos);
}

TEST_F(TestTexturedExtract, QualityIsCheckedAndOnlyColoursAreKept)
{
  this->WriteHardObj("hard", 4);
  this->ExpectError(this->Build({ "hard.obj", "-o", "m.kds", "--texture-quality", "0" }), 2,
    "kdstream-build: error: --texture-quality: \"0\" is neither a number from 1 to 100 nor "
    "lossless");
  ASSERT_EQ(
    this->Build({ "hard.obj", "-o", "m.kds", "--quiet", "--textures", "colors" }).exitCode, 0);
  EXPECT_EQ(this->Store({ "info", "m.kds" }).out.find("texture bytes"), std::string::npos);
  ASSERT_EQ(
    this->Build({ "hard.obj", "-o", "m.kds", "--quiet", "--textures", "tiles" }).exitCode, 0);
  EXPECT_NE(this->Store({ "info", "m.kds" }).out.find("texture bytes"), std::string::npos);
  EXPECT_NE(this->Store({ "info", "m.kds", "--json" }).out.find("\"tiles\""), std::string::npos);
}
