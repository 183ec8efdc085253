// SPDX-License-Identifier: BSD-3-Clause
// Texture tiles: every triangle finds the texels of its picture.
#include "filters/texture/MakeTile.h"
#include "filters/texture/PackBoxes.h"
#include "filters/texture/PictureTexels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

using namespace kdstream;

namespace
{

Picture RandomPicture(std::mt19937& random, std::size_t width, std::size_t height)
{
  Picture picture{ width, height, 1 + random() % 4, {} };
  for (std::size_t i = 0; i < width * height * picture.components; ++i)
  {
    picture.texels.push_back(static_cast<std::uint8_t>(random()));
  }
  return picture;
}

double Number(std::mt19937& random, double least, double most)
{
  return least + (most - least) * double(random() % 100001) / 100000;
}

struct Scene
{
  std::vector<Picture> pictures;
  TextureSet textures;
  std::vector<Triangle> triangles;
  TexturedTriangles textured;
};

// Strips of triangles that cross seams, mirrored strips, strips far outside 0-1, and single
// triangles; some have no coordinates or pictures.
Scene RandomScene(unsigned seed)
{
  std::mt19937 random(seed);
  Scene scene;
  for (std::size_t i = 0; i < 3; ++i)
  {
    const std::size_t height = 20 + random() % 60, width = 20 + random() % 60; // in a fixed order
    scene.pictures.push_back(RandomPicture(random, width, height));
  }
  scene.textures.pictures = 3;
  for (std::uint32_t i = 0; i < 6; ++i)
  {
    TexturedMaterial material;
    material.picture = i < 5 ? i % 3 : noPicture;
    material.color = { 0.2, 0.5, 0.7, 0.5 };
    material.opaque = random() % 2 == 0;
    material.wrapU = static_cast<TextureWrap>(random() % 3);
    material.wrapV = static_cast<TextureWrap>(random() % 3);
    material.transform = random() % 2 == 0 ? upsideDown : TextureTransform{};
    scene.textures.materials.push_back(material);
  }
  scene.textures.shown = NumberShownPictures(scene.textures);
  for (std::uint32_t strip = 0; strip < 12; ++strip)
  {
    const VertexId first = strip * 10;
    const double far = random() % 3 == 0 ? Number(random, -7, 7) : 0;
    const double size = random() % 6 == 0 ? Number(random, 0, 9) : 0.15;
    std::vector<PictureCoordinate> at;
    for (VertexId v = 0; v < 10; ++v)
    {
      at.push_back({ float(far + size * v / 2 + Number(random, -0.05, 0.05)),
        float((v % 2 == 0 ? 0.2 : 0.2 + size) + Number(random, -0.05, 0.05)) });
    }
    const auto material = static_cast<std::uint32_t>(random() % 6);
    for (VertexId v = 0; v < 8; ++v)
    {
      scene.triangles.push_back({ first + v, first + v + 1, first + v + 2 });
      const bool none = random() % 20 == 0;
      scene.textured.corners.push_back(none ? std::array{ at[v], noPictureCoordinate, at[v + 2] }
                                            : std::array{ at[v], at[v + 1], at[v + 2] });
      scene.textured.materialOf.push_back(material);
    }
  }
  scene.textured.triangles = scene.triangles;
  return scene;
}

// The texel of the whole picture at a place, as the material shows it.
Texel Shown(const Scene& scene, const TexturedMaterial& material, const PlaceInPicture& place)
{
  Texel texel =
    PictureTexels(scene.pictures[material.picture]).At(place, material.wrapU, material.wrapV);
  texel[3] = material.opaque ? std::uint8_t{ 255 } : texel[3];
  return texel;
}

Texel TexelOf(const Picture& picture, double x, double y)
{
  const std::size_t i = std::size_t(y) * picture.width + std::size_t(x);
  const auto rgba = RgbaOf(&picture.texels[i * picture.components], picture.components);
  return rgba;
}

// A weighted mean of the corners.
template <class Corners>
std::array<double, 2> Mix(const Corners& corners, const std::array<double, 3>& weights)
{
  std::array<double, 2> mixed{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    mixed[0] += weights[k] * double(corners[k][0]);
    mixed[1] += weights[k] * double(corners[k][1]);
  }
  return mixed;
}

bool NearEdge(double texel)
{
  return std::abs(texel - std::nearbyint(texel)) < 0.02;
}

}

// Tests random places in textured triangles, and two texels around them, which linear filters read.
TEST(MakeTile, LosslessTexelsAreThoseOfThePictures)
{
  std::size_t looked = 0, unpainted = 0;
  for (unsigned seed = 0; seed < 60; ++seed)
  {
    const Scene scene = RandomScene(seed);
    const PicturesInMemory source(scene.pictures);
    const auto made = MakeTile(scene.textured, scene.textures, source, { 0 });
    ASSERT_TRUE(made) << made.GetError().message;
    const auto blob = EncodeTextureTile(made->tile, scene.triangles);
    const auto tile = DecodeTextureTile(blob, scene.triangles);
    ASSERT_TRUE(tile) << tile.GetError().message;
    const auto picture = DecodePicture(tile->image);
    ASSERT_TRUE(picture) << picture.GetError().message;
    ASSERT_EQ(picture->width, tile->width);
    ASSERT_EQ(picture->height, tile->height);
    const TileCharts charts = FindTileCharts(scene.textured, scene.textures, source, 2);
    std::mt19937 random(seed);
    for (std::size_t t = 0; t < scene.triangles.size(); ++t)
    {
      const TexturedMaterial& material = scene.textures.materials[scene.textured.materialOf[t]];
      for (int i = 0; i < 20; ++i)
      {
        std::array<double, 3> weights{ Number(random, 0, 1), Number(random, 0, 1), 0 };
        weights[1] *= 1 - weights[0];
        weights[2] = 1 - weights[0] - weights[1];
        const auto at = Mix(tile->corners[t], weights);
        if (charts.ofTriangle[t].why != Untextured::No)
        {
          ++unpainted;
          const bool means = charts.ofTriangle[t].why == Untextured::Repeats;
          const auto alpha = std::uint8_t(material.opaque ? 255 : 128);
          const Texel color{ ByteOfLinear(0.2), ByteOfLinear(0.5), ByteOfLinear(0.7), alpha };
          ASSERT_TRUE(means || TexelOf(*picture, at[0], at[1]) == color);
          continue;
        }
        const auto in = Mix(charts.texels[t], weights);
        if (NearEdge(in[0]) || NearEdge(in[1]))
        {
          continue;
        }
        const double x = int(random() % 5) - 2, y = int(random() % 5) - 2;
        const Picture& whole = scene.pictures[material.picture];
        const PlaceInPicture place{ (in[0] + x) / double(whole.width),
          (in[1] + y) / double(whole.height) };
        ASSERT_EQ(TexelOf(*picture, at[0] + x, at[1] + y), Shown(scene, material, place))
          << seed << " " << t;
        ++looked;
      }
    }
  }
  EXPECT_GT(looked, 50000U);
  EXPECT_GT(unpainted, 10000U);
}

TEST(MakeTile, LossyOnesHaveTheSamePlaces)
{
  for (unsigned seed = 0; seed < 10; ++seed)
  {
    const Scene scene = RandomScene(seed);
    const PicturesInMemory source(scene.pictures);
    const auto lossless = MakeTile(scene.textured, scene.textures, source, { 0 });
    const auto lossy = MakeTile(scene.textured, scene.textures, source, { 80 });
    ASSERT_TRUE(lossless && lossy);
    ASSERT_EQ(lossless->tile.corners.size(), lossy->tile.corners.size());
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) // patches of colours are larger
    {
      const auto &a = lossless->tile.corners[t], &b = lossy->tile.corners[t];
      for (std::size_t i = 0; i < 6; ++i)
      {
        EXPECT_NEAR(a[i / 2][i % 2] - a[0][i % 2], b[i / 2][i % 2] - b[0][i % 2], 1e-3);
      }
    }
    const auto picture = DecodePicture(lossy->tile.image);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->width, lossy->tile.width);
  }
}

// A mesh of only one colour keeps it, however often its tile is halved.
TEST(MakeTile, LargeOnesAreHalved)
{
  Scene scene = RandomScene(5);
  for (Picture& picture : scene.pictures)
  {
    picture = { 700, 600, 1, std::vector<std::uint8_t>(700 * 600, 77) };
  }
  for (TexturedMaterial& material : scene.textures.materials)
  {
    material.opaque = true;
    material.color = { LinearOfBytes()[77], LinearOfBytes()[77], LinearOfBytes()[77], 1 };
  }
  const PicturesInMemory source(scene.pictures);
  const auto made = MakeTile(scene.textured, scene.textures, source, { 100, 256 });
  ASSERT_TRUE(made) << made.GetError().message;
  EXPECT_LE(std::max(made->tile.width, made->tile.height), 256U);
  EXPECT_EQ(made->counts.halved, 1U);
  const auto picture = DecodePicture(made->tile.image);
  ASSERT_TRUE(picture);
  for (const auto& corners : made->tile.corners)
  {
    const auto at = Mix(corners, { 0.3, 0.3, 0.4 });
    EXPECT_NEAR(TexelOf(*picture, at[0], at[1])[1], 77, 3);
  }
}

// Around the patches is noise, the worst case. Linear filters read four texels.
TEST(MakeTile, FlatColoursDoNotBleed)
{
  std::map<unsigned, int> worst; // by quality
  for (unsigned seed = 0; seed < 40; ++seed)
  {
    Scene scene = RandomScene(seed);
    std::mt19937 random(seed);
    const std::size_t colors = 1 + random() % 30, first = scene.textures.materials.size();
    for (std::size_t i = 0; i < colors; ++i)
    {
      TexturedMaterial material;
      material.color = { Number(random, 0, 1), Number(random, 0, 1), Number(random, 0, 1), 1 };
      scene.textures.materials.push_back(material);
      scene.triangles.push_back({ 0, 1, 2 });
      scene.textured.corners.push_back({});
      scene.textured.materialOf.push_back(static_cast<std::uint32_t>(first + i));
    }
    scene.textured.triangles = scene.triangles;
    for (TexturedMaterial& material : scene.textures.materials)
    {
      material.opaque = true;
    }
    const PicturesInMemory source(scene.pictures);
    for (const unsigned quality : { 75U, 90U })
    {
      const auto made = MakeTile(scene.textured, scene.textures, source, { quality });
      ASSERT_TRUE(made) << made.GetError().message;
      const auto picture = DecodePicture(made->tile.image);
      ASSERT_TRUE(picture) << picture.GetError().message;
      for (std::size_t t = scene.triangles.size() - colors; t < scene.triangles.size(); ++t)
      {
        const Color& color = scene.textures.materials[scene.textured.materialOf[t]].color;
        const auto at = made->tile.corners[t][0];
        for (int i = 0; i < 4; ++i)
        {
          const Texel texel = TexelOf(*picture, double(at[0]) - i % 2, double(at[1]) - i / 2);
          for (std::size_t k = 0; k < 3; ++k)
          {
            worst[quality] =
              std::max(worst[quality], std::abs(int{ texel[k] } - ByteOfLinear(color[k])));
          }
        }
      }
    }
  }
  // The error that quantisation and 8-bit YUV cause.
  EXPECT_LE(worst[90], 4);
  EXPECT_LE(worst[75], 6);
}

TEST(MakeTile, FactorsAreMultipliedIn)
{
  Scene scene;
  scene.pictures = { { 8, 8, 3, std::vector<std::uint8_t>(8 * 8 * 3, 200) } };
  TexturedMaterial material;
  material.picture = 0;
  material.factor = { 1, 0.5, 0, 1 };
  scene.textures = { { material }, 1 };
  scene.triangles = { { 0, 1, 2 } };
  scene.textured = { scene.triangles, { { { { 0, 0 }, { 1, 0 }, { 0, 1 } } } }, { 0 } };
  const auto made =
    MakeTile(scene.textured, scene.textures, PicturesInMemory(scene.pictures), { 0 });
  ASSERT_TRUE(made);
  const auto picture = DecodePicture(made->tile.image);
  ASSERT_TRUE(picture);
  const Texel lit{ 200, ByteOfLinear(LinearOfBytes()[200] * 0.5), 0, 255 };
  EXPECT_EQ(
    TexelOf(*picture, made->tile.corners[0][0][0] + 1, made->tile.corners[0][0][1] + 1), lit);
}

TEST(PackBoxes, LieBesideEachOther)
{
  for (unsigned seed = 0; seed < 50; ++seed)
  {
    std::mt19937 random(seed);
    std::vector<std::array<std::int64_t, 2>> sizes;
    std::int64_t area = 0;
    for (std::size_t i = random() % 200; i > 0; --i)
    {
      sizes.push_back({ std::int64_t(1 + random() % 50), std::int64_t(1 + random() % 50) });
      area += sizes.back()[0] * sizes.back()[1];
    }
    const auto packed = PackBoxes(sizes, 2000);
    ASSERT_TRUE(packed);
    std::vector<char> taken(std::size_t(packed->width * packed->height));
    for (std::size_t b = 0; b < sizes.size(); ++b)
    {
      const auto [x, y] = packed->places[b];
      ASSERT_LE(x + sizes[b][0], packed->width);
      ASSERT_LE(y + sizes[b][1], packed->height);
      for (std::int64_t i = 0; i < sizes[b][0] * sizes[b][1]; ++i)
      {
        char& texel =
          taken[std::size_t((y + i / sizes[b][0]) * packed->width + x + i % sizes[b][0])];
        ASSERT_EQ(texel, 0);
        texel = 1;
      }
    }
    EXPECT_TRUE(sizes.size() < 50 || double(packed->width * packed->height) < 1.3 * double(area));
    EXPECT_FALSE(sizes.size() > 50 && PackBoxes(sizes, 60));
  }
}
