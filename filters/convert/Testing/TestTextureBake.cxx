// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/TextureBake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace kdstream;

namespace
{

// A square of two triangles that a picture covers just so.
const std::vector<Vec3> square{ { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } };
const std::vector<Triangle> halves{ { 0, 1, 2 }, { 0, 2, 3 } };
const std::vector<PlaceOnTexture> corners{ { 0, 1 }, { 1, 1 }, { 1, 0 }, { 0, 0 } };

TexturePicture Grey(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& texels)
{
  return { width, height, 1, texels };
}

// Columns, black and white by turns.
std::vector<std::uint8_t> Stripes(std::size_t side)
{
  std::vector<std::uint8_t> texels(side * side);
  for (std::size_t i = 0; i < texels.size(); ++i)
  {
    texels[i] = i % 2 == 0 ? 0 : 255;
  }
  return texels;
}

}

TEST(TextureBake, FineTexelsGiveTheirMeanInLinearLight)
{
  const std::vector<std::uint8_t> stripes = Stripes(64);
  const BakedTexture baked = BakeTexture(Grey(64, 64, stripes), corners, square, halves);
  for (const Color& color : baked.colors)
  {
    EXPECT_NEAR(color[0], 0.5, 0.05); // one texel would be 0 or 1
    EXPECT_EQ(color[3], 1);
  }
  EXPECT_NEAR(baked.texels, 64 * 64, 1e-6);
  // Half of the light is 188 in sRGB: black is 188 off, white 67.
  EXPECT_NEAR(baked.loss, 127.5, 8);
}

TEST(TextureBake, OneColourIsKeptAsItIs)
{
  const std::vector<std::uint8_t> texels(16, 100);
  const BakedTexture baked = BakeTexture(Grey(4, 4, texels), corners, square, halves);
  for (const Color& color : baked.colors)
  {
    EXPECT_NEAR(255 * FromLinear(color[1]), 100, 1e-6);
  }
  EXPECT_NEAR(baked.loss, 0, 1e-6);
}

TEST(TextureBake, TheUpperHalfIsThatOfSmallV)
{
  // From the lowest row up: dark below, bright above.
  const std::vector<std::uint8_t> texels{ 0, 0, 255, 255 };
  const BakedTexture baked = BakeTexture(Grey(2, 2, texels), corners, square, halves);
  EXPECT_LT(baked.colors[0][0], 0.4); // v = 1
  EXPECT_GT(baked.colors[3][0], 0.6); // v = 0
}

TEST(TextureBake, BeyondTheEdgeIsWhatTheWrapSays)
{
  const std::vector<std::uint8_t> texels{ 0, 255 }; // dark to the left
  const std::vector<PlaceOnTexture> beyond(3, { 1.25, 0.5 });
  const std::vector<Triangle> one{ { 0, 1, 2 } };
  TexturePicture picture = Grey(2, 1, texels);
  const auto at = [&](TextureWrap wrap)
  {
    picture.wrapU = wrap;
    return BakeTexture(picture, beyond, std::span(square).first(3), one).colors[0][0];
  };
  EXPECT_EQ(at(TextureWrap::Repeat), 0);
  EXPECT_EQ(at(TextureWrap::Mirror), 1);
  EXPECT_EQ(at(TextureWrap::Clamp), 1);
}

TEST(TextureBake, CoordinatesOfAnyKindDoNoHarm)
{
  const std::vector<std::uint8_t> texels{ 0, 255 };
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const double odd : { none, 1e300, -1e300, 1e9 })
  {
    std::vector<PlaceOnTexture> coordinates = corners;
    coordinates[2] = { odd, odd };
    const BakedTexture baked = BakeTexture(Grey(2, 1, texels), coordinates, square, halves);
    ASSERT_EQ(baked.colors.size(), 4U);
    for (const Color& color : baked.colors)
    {
      EXPECT_TRUE(color[0] >= 0 && color[0] <= 1) << odd;
    }
    EXPECT_TRUE(std::isfinite(baked.loss) && std::isfinite(baked.texels)) << odd;
  }
  std::vector<PlaceOnTexture> coordinates(4, { none, none });
  EXPECT_EQ(
    BakeTexture(Grey(2, 1, texels), coordinates, square, halves).colors[1], (Color{ 1, 1, 1, 1 }));
}
