// SPDX-License-Identifier: BSD-3-Clause
// Pictures times colours of vertices: each texel is compared with what it is computed from.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/texture/TintPictures.h"
#include "filters/texture/WritePicture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>

using namespace kdstream;

namespace
{

constexpr Color white{ 1, 1, 1, 1 };
using Place = std::array<double, 2>;

class TestTintPictures : public ::testing::Test
{
protected:
  void AddPicture(std::uint32_t width, std::uint32_t height)
  {
    Picture picture{ width, height, 4, {} };
    for (std::size_t i = 0; i < std::size_t{ 4 } * width * height; ++i)
    {
      picture.texels.push_back(static_cast<std::uint8_t>(this->Random()));
    }
    this->Pictures.push_back(std::move(picture));
  }

  void AddMaterial(std::uint32_t picture, TextureWrap wrap = TextureWrap::Repeat)
  {
    TexturedMaterial& material = this->Before.materials.emplace_back();
    material.picture = picture;
    material.wrapU = material.wrapV = wrap;
  }

  void AddVertex(const Color& tint)
  {
    this->Before.mesh.points.push_back({ 0, 0, 0 });
    this->Tints.push_back(tint);
  }

  void AddTriangle(const Triangle& triangle, const std::array<PictureCoordinate, 3>& corners,
    std::uint32_t material)
  {
    this->Before.mesh.triangles.push_back(triangle);
    this->Before.corners.push_back(corners);
    this->Before.materialOf.push_back(material);
  }

  double Uniform() { return double(this->Random() % 4097) / 4096; }
  Color RandomTint() { return { this->Uniform(), this->Uniform(), this->Uniform(), 1 }; }

  // Writes the pictures, and calls the function under test.
  void Tint()
  {
    Result<TextureFolderWriter> writer =
      TextureFolderWriter::Create(this->Folder / "paint", this->Pictures.size());
    ASSERT_TRUE(writer);
    for (std::uint32_t i = 0; i < this->Pictures.size(); ++i)
    {
      const auto bytes = EncodePicture(this->Pictures[i], PictureType::Png);
      ASSERT_TRUE(writer->AddPicture(i, bytes, mostPicturePixels));
    }
    ASSERT_TRUE(writer->Finish(this->Before.materials));
    const auto source = TextureFolder::Open(this->Folder / "paint");
    ASSERT_TRUE(source);
    this->After = this->Before;
    const Result<bool> tinted = TintPictures(this->After, this->Tints, **source, *writer);
    ASSERT_TRUE(tinted) << tinted.GetError().message;
    this->WasTinted = *tinted;
    ASSERT_TRUE(writer->Finish(this->After.materials));
    const auto result = TextureFolder::Open(this->Folder / "paint");
    ASSERT_TRUE(result);
    this->Out = *result;
  }

  std::array<std::uint8_t, 4> TexelOf(std::uint32_t picture, std::int64_t x, std::int64_t y,
    TextureWrap wrap = TextureWrap::Clamp) const
  {
    const auto texels =
      ReadWrapped(*this->Out, picture, { { x, y }, { x + 1, y + 1 } }, wrap, wrap);
    return { (*texels)[0], (*texels)[1], (*texels)[2], (*texels)[3] };
  }

  std::array<Place, 3> TexelsOf(const TexturedMesh& mesh, std::size_t t) const
  {
    const auto [width, height] = this->Out->SizeOf(mesh.materials[mesh.materialOf[t]].picture);
    std::array<Place, 3> at;
    for (std::size_t k = 0; k < 3; ++k)
    {
      at[k] = { double(mesh.corners[t][k][0]) * width, double(mesh.corners[t][k][1]) * height };
    }
    return at;
  }

  static Place Mix(const std::array<Place, 3>& at, const std::array<double, 3>& weights)
  {
    Place mixed{};
    for (std::size_t i = 0; i < 2; ++i)
    {
      mixed[i] = weights[0] * at[0][i] + weights[1] * at[1][i] + weights[2] * at[2][i];
    }
    return mixed;
  }

  // The weights of a place within a triangle; nothing if it lies outside, or nearly.
  static std::optional<std::array<double, 3>> Within(const std::array<Place, 3>& at, Place place)
  {
    const double ax = at[1][0] - at[0][0], ay = at[1][1] - at[0][1];
    const double bx = at[2][0] - at[0][0], by = at[2][1] - at[0][1];
    const double px = place[0] - at[0][0], py = place[1] - at[0][1];
    const double area = ax * by - ay * bx;
    const double b = (px * by - py * bx) / area, c = (ax * py - ay * px) / area;
    const bool inside = b > 1e-6 && c > 1e-6 && b + c < 1 - 1e-6;
    return inside ? std::optional(std::array{ 1 - b - c, b, c }) : std::nullopt;
  }

  // Expects that every texel of a triangle is its texel before, times the tint there. Returns how
  // many were compared.
  std::size_t ExpectTinted(std::size_t t, double tolerance = 1.01) const
  {
    const TexturedMaterial& material = this->Before.materials[this->Before.materialOf[t]];
    const std::uint32_t page = this->After.materials[this->After.materialOf[t]].picture;
    const std::array<Place, 3> from = this->TexelsOf(this->Before, t);
    const std::array<Place, 3> to = this->TexelsOf(this->After, t);
    const auto range = [&](std::size_t i) {
      return std::minmax({ from[0][i], from[1][i], from[2][i] });
    };
    std::size_t compared = 0;
    for (double y = std::floor(range(1).first); y <= range(1).second; ++y)
    {
      for (double x = std::floor(range(0).first); x <= range(0).second; ++x)
      {
        const auto weights = Within(from, { x + 0.5, y + 0.5 });
        if (!weights)
        {
          continue;
        }
        const Place at = Mix(to, *weights);
        EXPECT_NEAR(at[0] - std::floor(at[0]), 0.5, 0.01);
        const auto before = this->TexelOf(material.picture, static_cast<std::int64_t>(x),
          static_cast<std::int64_t>(y), material.wrapU);
        const auto after = this->TexelOf(page, static_cast<std::int64_t>(std::floor(at[0])),
          static_cast<std::int64_t>(std::floor(at[1])));
        for (std::size_t c = 0; c < 3; ++c)
        {
          double tint = 0;
          for (std::size_t k = 0; k < 3; ++k)
          {
            tint += (*weights)[k] * this->Tints[this->Before.mesh.triangles[t][k]][c];
          }
          const double light = LinearOfBytes()[before[c]] * material.factor[c] * tint;
          EXPECT_NEAR(int{ after[c] }, 255 * FromLinear(light), tolerance)
            << "triangle " << t << " at " << x << ", " << y;
        }
        ++compared;
      }
    }
    return compared;
  }

  // A grid of quads over a part of a picture.
  void AddGrid(VertexId columns, VertexId rows, Place first, Place step, std::uint32_t material)
  {
    const auto begin = static_cast<VertexId>(this->Tints.size());
    const auto corner = [&](VertexId i, VertexId j)
    {
      return PictureCoordinate{ static_cast<float>(first[0] + step[0] * i),
        static_cast<float>(first[1] + step[1] * j) };
    };
    for (VertexId v = 0; v < (columns + 1) * (rows + 1); ++v)
    {
      this->AddVertex(this->RandomTint());
    }
    for (VertexId j = 0; j < rows; ++j)
    {
      for (VertexId i = 0; i < columns; ++i)
      {
        const VertexId a = begin + j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
        this->AddTriangle(
          { a, b, d }, { corner(i, j), corner(i + 1, j), corner(i + 1, j + 1) }, material);
        this->AddTriangle(
          { a, d, c }, { corner(i, j), corner(i + 1, j + 1), corner(i, j + 1) }, material);
      }
    }
  }

  std::mt19937 Random{ 40 };
  const fixtures::TemporaryFolder Folder;
  std::vector<Picture> Pictures;
  TexturedMesh Before, After;
  std::vector<Color> Tints;
  bool WasTinted = false;
  std::shared_ptr<const TextureFolder> Out;
};

TEST_F(TestTintPictures, EachTexelIsMultipliedByTheTintAtItsCentre)
{
  this->AddPicture(97, 61);
  this->AddPicture(40, 130);
  for (const TextureWrap wrap : { TextureWrap::Repeat, TextureWrap::Mirror, TextureWrap::Clamp })
  {
    this->AddMaterial(0, wrap);
    this->AddMaterial(1, wrap);
    this->Before.materials.back().factor = { 0.5, 1, 0.25, 1 };
  }
  for (std::uint32_t grid = 0; grid < 24; ++grid)
  {
    const Place first{ 4 * this->Uniform() - 2, 4 * this->Uniform() - 2 };
    const double sign = grid % 2 == 0 ? 1 : -1; // some are mirrored
    const Place step{ 0.07 + this->Uniform() / 4, sign * (0.07 + this->Uniform() / 4) };
    this->AddGrid(1 + grid % 5, 1 + grid % 4, first, step, grid % 6);
  }
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  std::size_t compared = 0;
  for (std::size_t t = 0; t < this->Before.mesh.triangles.size(); ++t)
  {
    compared += this->ExpectTinted(t);
    EXPECT_GE(this->After.materials[this->After.materialOf[t]].picture, 2U);
  }
  EXPECT_GT(compared, 5000U);
}

// Both halves of a symmetric model often show the same texels.
TEST_F(TestTintPictures, TrianglesThatShareTexelsWithOtherTintsGetTheirOwn)
{
  this->AddPicture(64, 64);
  this->AddMaterial(0);
  constexpr std::array<PictureCoordinate, 3> corners{ PictureCoordinate{ 0.1F, 0.1F },
    PictureCoordinate{ 0.9F, 0.2F }, PictureCoordinate{ 0.3F, 0.8F } };
  for (const double light : { 1.0, 0.5, 0.25, 0.1 })
  {
    this->AddVertex({ light, 1, light, 1 });
  }
  this->AddTriangle({ 0, 1, 2 }, corners, 0);
  this->AddTriangle({ 0, 1, 3 }, corners, 0); // folded along the first side
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  EXPECT_GT(this->ExpectTinted(0), 500U);
  EXPECT_GT(this->ExpectTinted(1), 500U);
}

TEST_F(TestTintPictures, ATriangleOfOneTintKeepsItsPicture)
{
  this->AddPicture(8, 8);
  this->AddMaterial(0);
  this->Before.materials[0].factor = { 0.5, 1, 1, 1 };
  for (const Color& tint : { white, Color{ 0.5, 0.25, 1, 1 } })
  {
    for (int k = 0; k < 3; ++k)
    {
      this->AddVertex(tint);
    }
  }
  constexpr std::array<PictureCoordinate, 3> corners{ PictureCoordinate{ 0, 0 },
    PictureCoordinate{ 1, 0 }, PictureCoordinate{ 0, 1 } };
  this->AddTriangle({ 0, 1, 2 }, corners, 0);
  this->AddTriangle({ 3, 4, 5 }, corners, 0);
  this->AddTriangle({ 5, 4, 3 }, corners, 0);
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  EXPECT_EQ(this->After.corners, this->Before.corners);
  EXPECT_EQ(this->After.materialOf, (std::vector<std::uint32_t>{ 0, 1, 1 }));
  EXPECT_EQ(this->After.materials[0].factor, this->Before.materials[0].factor);
  EXPECT_EQ(this->After.materials[1].factor, (Color{ 0.25, 0.25, 1, 1 }));
  EXPECT_EQ(this->After.materials[1].picture, 0U);
  EXPECT_EQ(this->Out->Content().pictures, 1U);
}

TEST_F(TestTintPictures, ATriangleWithoutAPictureShowsItsMaterialsColour)
{
  this->AddPicture(8, 8);
  this->AddMaterial(noPicture);
  this->Before.materials[0].color = { 0.5, 1, 1, 1 };
  this->AddVertex({ 1, 0, 0, 1 });
  this->AddVertex({ 0, 1, 0, 1 });
  this->AddVertex({ 0, 0, 1, 1 });
  this->AddTriangle(
    { 0, 1, 2 }, { noPictureCoordinate, noPictureCoordinate, noPictureCoordinate }, 0);
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  const std::array<Place, 3> at = this->TexelsOf(this->After, 0);
  const std::uint32_t page = this->After.materials[this->After.materialOf[0]].picture;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const auto texel = this->TexelOf(page, static_cast<std::int64_t>(std::floor(at[k][0])),
      static_cast<std::int64_t>(std::floor(at[k][1])));
    for (std::size_t c = 0; c < 3; ++c)
    {
      const double light = k != c ? 0 : c == 0 ? 0.5 : 1;
      EXPECT_NEAR(int{ texel[c] }, 255 * FromLinear(light), 1) << k << c;
    }
  }
}

// As in models that take all their colours from a few texels.
TEST_F(TestTintPictures, ATriangleWithinATexelShowsItsTints)
{
  this->AddPicture(8, 8);
  this->AddMaterial(0);
  this->AddVertex({ 1, 0, 0, 1 });
  this->AddVertex({ 0, 1, 0, 1 });
  this->AddVertex({ 0, 0, 1, 1 });
  constexpr PictureCoordinate place{ 0.3F, 0.7F }; // texel 2, 5
  this->AddTriangle({ 0, 1, 2 }, { place, place, place }, 0);
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  const std::array<Place, 3> at = this->TexelsOf(this->After, 0);
  const std::uint32_t page = this->After.materials[this->After.materialOf[0]].picture;
  const auto before = this->TexelOf(0, 2, 5);
  for (std::size_t k = 0; k < 3; ++k)
  {
    const auto texel = this->TexelOf(page, static_cast<std::int64_t>(std::floor(at[k][0])),
      static_cast<std::int64_t>(std::floor(at[k][1])));
    for (std::size_t c = 0; c < 3; ++c)
    {
      EXPECT_EQ(int{ texel[c] }, k == c ? int{ before[c] } : 0) << k << c;
    }
  }
}

TEST_F(TestTintPictures, PicturesThatWouldBecomeTooLargeAreNotMade)
{
  this->AddPicture(512, 512);
  this->AddMaterial(0);
  for (VertexId i = 0; i < 300; ++i) // 300 times the whole picture
  {
    this->AddGrid(1, 1, { 0, 0 }, { 1, 1 }, 0);
  }
  this->Tint();
  EXPECT_FALSE(this->WasTinted);
  EXPECT_EQ(this->After.corners, this->Before.corners);
  EXPECT_EQ(this->After.materialOf, this->Before.materialOf);
  EXPECT_EQ(this->After.materials.size(), this->Before.materials.size());
}

TEST_F(TestTintPictures, AnyNumbersAreTaken)
{
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const std::array<double, 8> odd{ std::nan(""), infinite, -infinite, -1, 0, 1e300, 0.5, 3 };
  const std::array<float, 8> places{ std::nanf(""), std::numeric_limits<float>::infinity(), -1e30F,
    1e9F, 0, 0.5F, -3.7F, 5e-5F };
  this->AddPicture(16, 16);
  this->AddPicture(1, 1);
  this->AddMaterial(0);
  this->AddMaterial(1, TextureWrap::Mirror);
  this->AddMaterial(noPicture);
  for (VertexId i = 0; i < 2000; ++i)
  {
    const auto part = [&] { return odd[this->Random() % odd.size()]; };
    this->AddVertex({ part(), part(), part(), part() });
    const VertexId count = std::min<VertexId>(i + 1, 40);
    const auto corner = [&] { return i - this->Random() % count; };
    const auto place = [&]
    {
      return PictureCoordinate{ places[this->Random() % places.size()],
        places[this->Random() % places.size()] };
    };
    const Triangle triangle{ static_cast<VertexId>(corner()), static_cast<VertexId>(corner()),
      static_cast<VertexId>(corner()) };
    this->AddTriangle(
      triangle, { place(), place(), place() }, static_cast<std::uint32_t>(this->Random() % 3));
  }
  this->Tint();
  ASSERT_TRUE(this->WasTinted);
  for (std::size_t t = 0; t < this->After.corners.size(); ++t)
  {
    ASSERT_LT(this->After.materialOf[t], this->After.materials.size());
  }
}

}
