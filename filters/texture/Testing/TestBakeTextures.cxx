// SPDX-License-Identifier: BSD-3-Clause
// BakeTextures: the colours that vertices get from the texels around them.
#include "filters/texture/BakeTextures.h"
#include "filters/texture/WritePicture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace kdstream;

namespace
{

constexpr float none = std::numeric_limits<float>::quiet_NaN();

Picture Grey(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& texels)
{
  return { width, height, 1, texels };
}

PictureSource Embedded(const Picture& picture)
{
  return { "picture", {}, 0, 0, EncodePicture(picture, PictureType::Png) };
}

// A square of two triangles, covered by the whole picture: v is 0 at y = 1.
TexturedMesh Square(const Picture& picture)
{
  TexturedMesh textured;
  textured.mesh.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } };
  textured.mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  textured.corners = { { { { 0, 1 }, { 1, 1 }, { 1, 0 } } }, { { { 0, 1 }, { 1, 0 }, { 0, 0 } } } };
  textured.materialOf = { 0, 0 };
  TexturedMaterial material;
  material.picture = 0;
  textured.materials = { material };
  textured.pictures = { Embedded(picture) };
  return textured;
}

const Attribute& ColorsOf(const TexturedMesh& textured)
{
  return textured.mesh.attributes.back();
}

// A random soup of triangles with coordinates far outside 0-1, several materials and pictures.
TexturedMesh Soup(unsigned seed, const std::vector<Picture>& pictures)
{
  std::mt19937 random(seed);
  const auto number = [&]() { return double(random() % 2000) / 1000 - 1; };
  TexturedMesh textured;
  for (int i = 0; i < 40; ++i)
  {
    textured.mesh.points.push_back({ number(), number(), number() });
  }
  for (const Picture& picture : pictures)
  {
    TexturedMaterial material;
    material.picture = static_cast<std::uint32_t>(textured.pictures.size());
    material.wrapU = static_cast<TextureWrap>(random() % 3);
    material.wrapV = static_cast<TextureWrap>(random() % 3);
    material.transform = { { number(), number(), number() }, { number(), number(), number() } };
    textured.materials.push_back(material);
    textured.pictures.push_back(Embedded(picture));
  }
  for (int i = 0; i < 100; ++i)
  {
    const auto vertex = [&]() { return static_cast<VertexId>(random() % 40); };
    const auto at = [&]() { return PictureCoordinate{ float(9 * number()), float(9 * number()) }; };
    textured.mesh.triangles.push_back({ vertex(), vertex(), vertex() });
    textured.corners.push_back({ at(), at(), at() });
    textured.materialOf.push_back(static_cast<std::uint32_t>(random() % pictures.size()));
  }
  return textured;
}

}

TEST(Light, BytesComeBack)
{
  for (unsigned byte = 0; byte < 256; ++byte)
  {
    EXPECT_EQ(ByteOfLinear(LinearOfBytes()[byte]), byte);
    EXPECT_NEAR(255 * FromLinear(LinearOfBytes()[byte]), byte, 1e-6);
  }
  EXPECT_EQ(ByteOfLinear(-1), 0);
  EXPECT_EQ(ByteOfLinear(7), 255);
  EXPECT_EQ(ByteOfLinear(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(BakeTextures, OneColourIsKeptWhateverTheCoordinates)
{
  for (unsigned seed = 0; seed < 30; ++seed)
  {
    const auto value = static_cast<std::uint8_t>(seed * 8);
    const Picture one = Grey(4, 3, std::vector<std::uint8_t>(12, value));
    TexturedMesh textured = Soup(seed, { one, one });
    std::vector<bool> used(40);
    for (const Triangle& t : textured.mesh.triangles)
    {
      used[t[0]] = used[t[1]] = used[t[2]] = true;
    }
    const Result<BakeReport> report = BakeTextures(textured);
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->warnings.empty());
    EXPECT_EQ(report->pictures, 2U);
    for (std::size_t v = 0; v < used.size(); ++v)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ASSERT_EQ(ColorsOf(textured).Get(v, k), used[v] ? value : 255) << seed << " " << v;
      }
    }
    EXPECT_LT(report->loss, 0.01);
  }
}

TEST(BakeTextures, FineTexelsGiveTheirMeanInLinearLight)
{
  std::vector<std::uint8_t> board(64 * 64);
  for (std::size_t i = 0; i < board.size(); ++i)
  {
    board[i] = (i + i / 64) % 2 == 0 ? 0 : 255;
  }
  TexturedMesh textured = Square(Grey(64, 64, board));
  const Result<BakeReport> report = BakeTextures(textured);
  ASSERT_TRUE(report);
  for (std::size_t v = 0; v < 4; ++v)
  {
    EXPECT_NEAR(ColorsOf(textured).Get(v, 0), 188, 5); // half the light; one texel: 0 or 255
  }
  EXPECT_NEAR(report->texels, 64 * 64, 1e-6);
  EXPECT_NEAR(report->texelsPerVertex, 64 * 16, 1e-6);
  // Black texels differ by 188, white ones by 67.
  EXPECT_NEAR(report->loss, std::sqrt((188 * 188 + 67 * 67) / 2.0), 4);
}

TEST(BakeTextures, NearTexelsCountMore)
{
  // The picture is dark above and bright below.
  TexturedMesh textured = Square(Grey(1, 2, { 0, 255 }));
  ASSERT_TRUE(BakeTextures(textured));
  const Attribute& colors = ColorsOf(textured);
  EXPECT_GT(ToLinear(colors.Get(0, 0) / 255), 0.6); // y = 0
  EXPECT_LT(ToLinear(colors.Get(3, 0) / 255), 0.4); // y = 1
}

TEST(BakeTextures, LossIsWhatALoopOverTexelsFinds)
{
  std::mt19937 random(3);
  std::vector<std::uint8_t> texels(16 * 16);
  for (std::uint8_t& texel : texels)
  {
    texel = static_cast<std::uint8_t>(random() & 255U);
  }
  TexturedMesh textured = Square(Grey(16, 16, texels));
  const Result<BakeReport> report = BakeTextures(textured);
  ASSERT_TRUE(report);
  // Computes the same error by fine sampling, without the sums that BakeTextures uses.
  const Attribute& colors = ColorsOf(textured);
  double sum = 0;
  constexpr int side = 512;
  for (int i = 0; i < side * side; ++i)
  {
    const double x = (i % side + 0.5) / side, y = (i / side + 0.5) / side;
    const auto texel = texels[std::size_t((1 - y) * 16) * 16 + std::size_t(x * 16)];
    const double between =
      x > y ? (1 - x) * colors.Get(0, 0) + (x - y) * colors.Get(1, 0) + y * colors.Get(2, 0)
            : (1 - y) * colors.Get(0, 0) + x * colors.Get(2, 0) + (y - x) * colors.Get(3, 0);
    sum += (texel - between) * (texel - between);
  }
  EXPECT_NEAR(report->loss, std::sqrt(sum / side / side), 1.5);
}

TEST(BakeTextures, BeyondTheEdgeIsWhatTheWrapSays)
{
  const auto at = [](TextureWrap wrap, float place, bool across)
  {
    TexturedMesh textured =
      Square(across ? Grey(2, 1, { 10, 200 }) : Grey(1, 2, { 10, 200 })); // at the low end: 10
    const PictureCoordinate c =
      across ? PictureCoordinate{ place, 0.5F } : PictureCoordinate{ 0.5F, place };
    textured.corners = { { c, c, c }, { c, c, c } };
    (across ? textured.materials[0].wrapU : textured.materials[0].wrapV) = wrap;
    EXPECT_TRUE(BakeTextures(textured));
    return ColorsOf(textured).Get(0, 0);
  };
  for (const bool across : { true, false })
  {
    EXPECT_EQ(at(TextureWrap::Repeat, 1.25F, across), 10);
    EXPECT_EQ(at(TextureWrap::Mirror, 1.25F, across), 200);
    EXPECT_EQ(at(TextureWrap::Clamp, 1.25F, across), 200);
    EXPECT_EQ(at(TextureWrap::Repeat, -0.25F, across), 200);
    EXPECT_EQ(at(TextureWrap::Mirror, -0.25F, across), 10);
    EXPECT_EQ(at(TextureWrap::Clamp, -0.25F, across), 10);
    EXPECT_EQ(at(TextureWrap::Mirror, 2.25F, across), 10);
  }
}

TEST(BakeTextures, TransformsAreOfTheCoordinates)
{
  TexturedMesh textured = Square(Grey(1, 2, { 0, 255 }));
  textured.materials[0].transform = upsideDown;
  ASSERT_TRUE(BakeTextures(textured));
  EXPECT_LT(ToLinear(ColorsOf(textured).Get(0, 0) / 255), 0.4); // y = 0
}

TEST(BakeTextures, CornersWithoutCoordinatesHaveTheMaterialsColour)
{
  TexturedMesh textured = Square(Grey(2, 1, { 0, 0 }));
  textured.mesh.points.push_back({ 2, 0, 0 });
  textured.mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 }, { 1, 4, 2 }, { 4, 1, 2 } };
  textured.corners.push_back({ { { none, 0 }, { 0, 0 }, { 0, 0 } } });
  textured.corners.push_back(
    { { { 0, 0 }, { 0, std::numeric_limits<float>::infinity() }, { 0, 0 } } });
  textured.materialOf = { 0, 0, 0, 0 };
  textured.materials[0].color = { 1, 0, LinearOfBytes()[100], 1 };
  const Result<BakeReport> report = BakeTextures(textured);
  ASSERT_TRUE(report);
  ASSERT_EQ(report->warnings.size(), 1U);
  EXPECT_EQ(report->warnings[0].rfind("2 triangles ", 0), 0U);
  EXPECT_NE(report->warnings[0].find("triangle 2"), std::string::npos) << "the first";
  EXPECT_EQ(ColorsOf(textured).Get(4, 0), 255);
  EXPECT_EQ(ColorsOf(textured).Get(4, 1), 0);
  EXPECT_EQ(ColorsOf(textured).Get(4, 2), 100);
  EXPECT_EQ(ColorsOf(textured).Get(3, 0), 0);
}

TEST(BakeTextures, UnreadablePicturesAreNamed)
{
  TexturedMesh textured = Square(Grey(1, 1, { 0 }));
  textured.materials[0].color = { 0, 1, 0, 1 };
  textured.pictures[0].bytes = { 'G', 'I', 'F' };
  const Result<BakeReport> report = BakeTextures(textured);
  ASSERT_TRUE(report);
  ASSERT_EQ(report->warnings.size(), 1U);
  EXPECT_EQ(report->warnings[0].rfind("picture: ", 0), 0U);
  EXPECT_EQ(report->pictures, 0U);
  EXPECT_EQ(ColorsOf(textured).Get(2, 1), 255);
  EXPECT_EQ(ColorsOf(textured).Get(2, 0), 0);
}

TEST(BakeTextures, VerticesInOnePlaceHaveOneColourUnlessTheirNormalsDiffer)
{
  // Two triangles that meet along a seam, dark and bright.
  TexturedMesh textured;
  textured.mesh.points = { { 0, 0, 0 }, { 0, 1, 0 }, { -1, 0, 0 }, { 0, 0, 0 }, { 0, 1, 0 },
    { 1, 0, 0 } };
  textured.mesh.triangles = { { 0, 1, 2 }, { 3, 5, 4 } };
  const PictureCoordinate left{ 0.25F, 0.5F }, right{ 0.75F, 0.5F };
  textured.corners = { { left, left, left }, { right, right, right } };
  textured.materialOf = { 0, 0 };
  textured.materials.resize(1);
  textured.materials[0].picture = 0;
  textured.pictures = { Embedded(Grey(2, 1, { 0, 255 })) };
  TexturedMesh split = textured;
  ASSERT_TRUE(BakeTextures(textured));
  EXPECT_EQ(ColorsOf(textured).Get(0, 0), 188);
  EXPECT_EQ(ColorsOf(textured).Get(3, 0), 188);
  EXPECT_EQ(ColorsOf(textured).Get(2, 0), 0);
  EXPECT_EQ(ColorsOf(textured).Get(5, 0), 255);
  Attribute normals{ { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 }, {} };
  normals.values.resize(6 * normals.TupleSize());
  for (std::size_t v = 0; v < 6; ++v)
  {
    normals.Set(v, 2, v == 0 ? -1 : 1); // normals differ only at the first place
  }
  split.mesh.attributes.push_back(normals);
  ASSERT_TRUE(BakeTextures(split));
  EXPECT_EQ(ColorsOf(split).Get(0, 0), 0);
  EXPECT_EQ(ColorsOf(split).Get(3, 0), 255);
  EXPECT_EQ(ColorsOf(split).Get(1, 0), 188);
}

TEST(BakeTextures, AlphaIsAMeanOfItsOwn)
{
  TexturedMesh textured = Square(Picture{ 2, 1, 2, { 50, 255, 50, 0 } });
  TexturedMesh opaque = textured;
  textured.materials[0].opaque = false;
  ASSERT_TRUE(BakeTextures(textured));
  ASSERT_EQ(ColorsOf(textured).components, 4);
  EXPECT_EQ(ColorsOf(textured).Get(0, 0), 50);
  EXPECT_GT(ColorsOf(textured).Get(0, 3), 140); // the left side
  EXPECT_LT(ColorsOf(textured).Get(1, 3), 110);
  ASSERT_TRUE(BakeTextures(opaque));
  EXPECT_EQ(ColorsOf(opaque).components, 3);
}

TEST(BakeTextures, HugeCoordinatesAndPlacesDoNoHarm)
{
  for (const float odd : { 1e30F, -1e30F, 1e9F })
  {
    TexturedMesh textured = Square(Grey(2, 1, { 0, 255 }));
    textured.corners[0][1] = { odd, odd };
    textured.materials[0].transform = { { 1e300, 1e300, 0 }, { -1e300, 1, 1 } };
    textured.mesh.points[2] = { double(odd) * 1e200, 1, 0 };
    const Result<BakeReport> report = BakeTextures(textured);
    ASSERT_TRUE(report);
    EXPECT_TRUE(std::isfinite(report->loss) && std::isfinite(report->texels)) << odd;
  }
}

TEST(BakeTextures, TrianglesWithoutAreaCountWhereThereAreNoOthers)
{
  TexturedMesh textured = Square(Grey(2, 1, { 0, 255 }));
  const PictureCoordinate right{ 0.75F, 0.5F };
  textured.mesh.points = { { 0, 0, 0 }, { 0, 0, 0.5 }, { 0, 0, 1 }, { 1, 1, 0 } };
  textured.mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  textured.corners = { { right, right, right }, { { { 0, 0 }, { 0, 0 }, { 0, 0 } } } };
  ASSERT_TRUE(BakeTextures(textured));
  EXPECT_EQ(ColorsOf(textured).Get(1, 0), 255);
  EXPECT_EQ(ColorsOf(textured).Get(0, 0), 0);
}
