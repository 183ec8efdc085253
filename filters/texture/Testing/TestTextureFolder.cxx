// SPDX-License-Identifier: BSD-3-Clause
// Decoded pictures in files, and materials as arrays, come back as they were written.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/texture/TextureArrays.h"
#include "filters/texture/TextureFolder.h"
#include "filters/texture/WritePicture.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class TestTextureFolder : public ::testing::Test
{
protected:
  static Picture RandomPicture(std::mt19937& random)
  {
    Picture picture{ 1 + random() % 200, 1 + random() % 200, 1 + random() % 4, {} };
    for (std::size_t i = 0; i < picture.width * picture.height * picture.components; ++i)
    {
      picture.texels.push_back(static_cast<std::uint8_t>(random()));
    }
    return picture;
  }

  // Picture 1 of three was not read.
  void Write(const std::vector<Picture>& pictures, const std::vector<TexturedMaterial>& materials)
  {
    Result<TextureFolderWriter> writer =
      TextureFolderWriter::Create(this->Folder / "paint", pictures.size());
    ASSERT_TRUE(writer);
    for (std::uint32_t i = 0; i < pictures.size(); ++i)
    {
      if (!pictures[i].texels.empty())
      {
        const auto bytes = EncodePicture(pictures[i], PictureType::Png);
        const auto mapped = writer->AddPicture(i, bytes, mostPicturePixels);
        ASSERT_TRUE(mapped) << mapped.GetError().message;
        this->ExpectTexels(pictures[i], mapped->Texels());
      }
    }
    ASSERT_TRUE(writer->Finish(materials));
  }

  static void ExpectTexels(const Picture& picture, const TexelLayout& texels)
  {
    const PictureTexels memory(picture), mapped(texels);
    ASSERT_EQ(memory.Count(), mapped.Count());
    for (std::size_t y = 0; y < picture.height; ++y)
    {
      for (std::size_t x = 0; x < picture.width; ++x)
      {
        const PlaceInPicture place{ (double(x) + 0.5) / double(picture.width),
          (double(y) + 0.5) / double(picture.height) };
        ASSERT_EQ(memory.At(place, TextureWrap::Clamp, TextureWrap::Clamp),
          mapped.At(place, TextureWrap::Clamp, TextureWrap::Clamp));
      }
    }
  }

  std::string WhyNot()
  {
    const auto opened = TextureFolder::Open(this->Folder / "paint");
    return opened ? "none" : opened.GetError().message;
  }

  const fixtures::TemporaryFolder Folder;
};

}

TEST_F(TestTextureFolder, TexelsAndMaterialsComeBack)
{
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    std::mt19937 random(seed);
    const std::vector<Picture> pictures{ RandomPicture(random), {}, RandomPicture(random) };
    TexturedMaterial material;
    material.color = { 0.1, 0.2, 0.3, 0.4 };
    material.factor = { 0.5, 0.6, 0.7, 0.8 };
    material.picture = 2;
    material.wrapU = TextureWrap::Mirror;
    material.wrapV = TextureWrap::Clamp;
    material.transform = { { 1, 2, 3 }, { 4, 5, 6 } };
    material.opaque = false;
    this->Write(pictures, { TexturedMaterial{}, material });
    const auto folder = TextureFolder::Open(this->Folder / "paint");
    ASSERT_TRUE(folder) << folder.GetError().message;
    const TextureSet& textureSet = (*folder)->Content();
    ASSERT_EQ(textureSet.pictures, 3U);
    ASSERT_EQ(textureSet.materials.size(), 2U);
    EXPECT_EQ(textureSet.materials[0].picture, noPicture);
    EXPECT_TRUE(textureSet.materials[0].opaque);
    const TexturedMaterial& back = textureSet.materials[1];
    EXPECT_EQ(back.color, material.color);
    EXPECT_EQ(back.factor, material.factor);
    EXPECT_EQ(back.picture, 2U);
    EXPECT_EQ(back.wrapU, material.wrapU);
    EXPECT_EQ(back.wrapV, material.wrapV);
    EXPECT_EQ(back.transform.u, material.transform.u);
    EXPECT_EQ(back.transform.v, material.transform.v);
    EXPECT_FALSE(back.opaque);
    const PicturesInMemory memory(pictures);
    for (std::uint32_t picture = 0; picture < 3; ++picture)
    {
      const auto size = memory.SizeOf(picture);
      ASSERT_EQ((*folder)->SizeOf(picture), size);
      for (int i = 0; size[0] > 0 && i < 20; ++i)
      {
        TexelBox box;
        for (std::size_t k = 0; k < 2; ++k)
        {
          box.lo[k] = random() % size[k];
          box.hi[k] = box.lo[k] + 1 + random() % (size[k] - std::size_t(box.lo[k]));
        }
        std::vector<std::uint8_t> a(std::size_t(4 * box.Width() * box.Height())), b(a.size());
        ASSERT_TRUE(memory.Read(picture, box, a.data()));
        ASSERT_TRUE((*folder)->Read(picture, box, b.data()));
        ASSERT_EQ(a, b);
      }
    }
  }
}

TEST_F(TestTextureFolder, PicturesThatCannotBeReadOrWrittenAreErrors)
{
  Result<TextureFolderWriter> writer = TextureFolderWriter::Create(this->Folder / "paint", 2);
  ASSERT_TRUE(writer);
  std::mt19937 random(1);
  std::vector<std::uint8_t> bytes = EncodePicture(RandomPicture(random), PictureType::Png);
  const auto huge = writer->AddPicture(0, bytes, 1);
  EXPECT_EQ(huge.GetError().code, ErrorCode::LimitExceeded);
  bytes.resize(bytes.size() / 2);
  const auto damaged = writer->AddPicture(0, bytes, mostPicturePixels);
  EXPECT_EQ(damaged.GetError().code, ErrorCode::InvalidInput);
  fs::create_directory(this->Folder / "paint" / "picture-1");
  const auto unwritable = writer->AddPicture(
    1, EncodePicture(RandomPicture(random), PictureType::Png), mostPicturePixels);
  EXPECT_EQ(unwritable.GetError().code, ErrorCode::InputOutput);
  ASSERT_TRUE(writer->Finish({}));
  const auto folder = TextureFolder::Open(this->Folder / "paint");
  ASSERT_TRUE(folder) << folder.GetError().message;
  EXPECT_EQ((*folder)->SizeOf(0), (std::array<std::uint32_t, 2>{}));
}

TEST_F(TestTextureFolder, WrongOnesAreRefused)
{
  EXPECT_EQ(this->WhyNot(), "is not there");
  std::mt19937 random(1);
  const std::vector<Picture> pictures{ RandomPicture(random) };
  TexturedMaterial material;
  material.picture = 0;
  this->Write(pictures, { material });
  EXPECT_EQ(this->WhyNot(), "none");
  const fs::path index = this->Folder / "paint" / "paint";
  const auto size = fs::file_size(index);
  fs::resize_file(index, size - 1);
  EXPECT_NE(this->WhyNot().find("truncated"), std::string::npos) << this->WhyNot();
  material.picture = 1;
  this->Write(pictures, { material });
  EXPECT_NE(this->WhyNot().find("a material whose picture does not exist"), std::string::npos);
  material.picture = 0;
  this->Write(pictures, { material });
  std::ofstream(index, std::ios::app) << "x";
  EXPECT_EQ(this->WhyNot(), "bytes beyond the end");
  this->Write(pictures, { material });
  fs::resize_file(this->Folder / "paint" / "picture-0", 100);
  EXPECT_EQ(this->WhyNot(), "has another size than its picture");
  fs::remove(this->Folder / "paint" / "picture-0");
  EXPECT_NE(this->WhyNot().find("cannot be read: "), std::string::npos);
}

// Compares any box that a chart may need, texel by texel, with what each wrap mode gives.
TEST(TexelSource, BoxesAnywhereAreWrapped)
{
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round)
  {
    Picture picture{ 1 + random() % 9, 1 + random() % 9, 1, {} };
    for (std::size_t i = 0; i < picture.width * picture.height; ++i)
    {
      picture.texels.push_back(static_cast<std::uint8_t>(i));
    }
    const auto wrapU = static_cast<TextureWrap>(random() % 3);
    const auto wrapV = static_cast<TextureWrap>(random() % 3);
    const auto at = [&]() { return std::int64_t(random() % 60) - 30; };
    TexelBox box{ { at(), at() }, {} };
    box.hi = { box.lo[0] + 1 + std::int64_t(random() % 30),
      box.lo[1] + 1 + std::int64_t(random() % 30) };
    const auto texels = ReadWrapped(PicturesInMemory({ picture }), 0, box, wrapU, wrapV);
    ASSERT_TRUE(texels);
    const auto inside = [](std::int64_t i, std::size_t size, TextureWrap wrap)
    {
      const auto n = static_cast<std::int64_t>(size);
      const std::int64_t period = wrap == TextureWrap::Mirror ? 2 * n : n;
      const std::int64_t t = (i % period + period) % period;
      return wrap == TextureWrap::Clamp ? std::clamp<std::int64_t>(i, 0, n - 1)
             : t < n                    ? t
                                        : 2 * n - 1 - t;
    };
    for (std::int64_t y = box.lo[1]; y < box.hi[1]; ++y)
    {
      for (std::int64_t x = box.lo[0]; x < box.hi[0]; ++x)
      {
        const std::int64_t from = inside(y, picture.height, wrapV) * std::int64_t(picture.width) +
                                  inside(x, picture.width, wrapU);
        const std::int64_t to = (y - box.lo[1]) * box.Width() + x - box.lo[0];
        ASSERT_EQ((*texels)[std::size_t(4 * to)], picture.texels[std::size_t(from)]);
      }
    }
  }
}

TEST(TextureArrays, ComeBackFromAPiece)
{
  TexturedMesh textured;
  textured.mesh.points = { {}, {}, {} };
  textured.mesh.triangles = { { 0, 1, 2 }, { 0, 2, 1 } };
  textured.corners = { { { { 1, 2 }, { 3, 4 }, noPictureCoordinate } },
    { { { -0.0F, 1e30F }, { 5, 6 }, { 7, 8 } } } };
  textured.materialOf = { 4, 70000 };
  AddTextureArrays(textured);
  AddTextureArrays(textured); // replaces the first ones
  ASSERT_EQ(textured.mesh.attributes.size(), 2U);
  Piece piece;
  piece.triangles = textured.mesh.triangles;
  piece.attributes = textured.mesh.attributes;
  Piece other = piece;
  const auto taken = TakeTextureArrays(piece, 70001);
  ASSERT_TRUE(taken);
  EXPECT_TRUE(piece.attributes.empty());
  EXPECT_EQ(taken->materialOf, textured.materialOf);
  EXPECT_EQ(taken->corners[1], textured.corners[1]);
  EXPECT_EQ(taken->corners[0][1], textured.corners[0][1]);
  EXPECT_TRUE(std::isnan(taken->corners[0][2][0]));
  Piece third = other;
  EXPECT_FALSE(TakeTextureArrays(other, 70000)) << "a material that is not there";
  third.attributes.pop_back();
  EXPECT_FALSE(TakeTextureArrays(third, 70001)) << "no materials";
}

// A tileset may have more pictures than a process may have open files.
TEST_F(TestTextureFolder, MorePicturesThanOpenFiles)
{
  constexpr std::uint8_t count = 250;
  std::vector<Picture> pictures;
  for (std::uint8_t i = 0; i < count; ++i)
  {
    pictures.push_back({ 1, 1, 3, { i, 2, 3 } });
  }
  std::vector<Picture> all;
  for (int times = 0; times < 3; ++times)
  {
    all.insert(all.end(), pictures.begin(), pictures.end());
  }
  this->Write(all, {});
  rlimit limits{};
  ::getrlimit(RLIMIT_NOFILE, &limits);
  rlimit few = limits;
  few.rlim_cur = 600;
  ::setrlimit(RLIMIT_NOFILE, &few);
  const auto opened = TextureFolder::Open(this->Folder / "paint");
  ::setrlimit(RLIMIT_NOFILE, &limits);
  ASSERT_TRUE(opened) << opened.GetError().message;
  for (std::uint32_t i = 0; i < all.size(); ++i)
  {
    std::array<std::uint8_t, 4> texel{};
    ASSERT_TRUE((*opened)->Read(i, { { 0, 0 }, { 1, 1 } }, texel.data())) << i;
    EXPECT_EQ(texel[0], i % count);
  }
}
