// SPDX-License-Identifier: BSD-3-Clause
// Pictures of all kinds, and files that are not pictures or claim too much.
#include "filters/texture/Picture.h"
#include "filters/texture/Testing/OddPictures.h"
#include "filters/texture/WritePicture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <utility>

using namespace kdstream;
using namespace kdstream::test;

namespace
{

Picture Noise(std::size_t width, std::size_t height, std::size_t components, unsigned seed)
{
  std::mt19937 random(seed);
  Picture picture{ width, height, components, Bytes(width * height * components) };
  for (std::uint8_t& value : picture.texels)
  {
    value = static_cast<std::uint8_t>(random() & 255U);
  }
  return picture;
}

std::string ErrorOf(const Bytes& bytes, std::uint64_t most = mostPicturePixels)
{
  const Result<Picture> picture = DecodePicture(bytes, most);
  return picture ? "none" : picture.GetError().message;
}

ErrorCode CodeOf(const Bytes& bytes, std::uint64_t most = mostPicturePixels)
{
  const Result<Picture> picture = DecodePicture(bytes, most);
  EXPECT_FALSE(picture);
  return picture ? ErrorCode{} : picture.GetError().code;
}

}

TEST(Picture, LosslessOnesComeBackToTheBit)
{
  for (std::size_t components = 1; components <= 4; ++components)
  {
    const Picture made = Noise(13, 7, components, unsigned(components));
    const Result<Picture> png = DecodePicture(EncodePicture(made, PictureType::Png));
    ASSERT_TRUE(png) << png.GetError().message;
    EXPECT_EQ(png->components, components);
    EXPECT_EQ(png->width, 13U);
    EXPECT_EQ(png->height, 7U);
    EXPECT_EQ(png->texels, made.texels);
  }
  const Picture opaque = Noise(17, 5, 3, 9);
  const Result<Picture> webp = DecodePicture(EncodePicture(opaque, PictureType::Webp));
  ASSERT_TRUE(webp) << webp.GetError().message;
  EXPECT_EQ(webp->texels, opaque.texels);
  Picture clear = Noise(17, 5, 4, 10);
  for (std::size_t i = 3; i < clear.texels.size(); i += 4)
  {
    clear.texels[i] |= 1; // WebP drops the colour of invisible texels
  }
  const Result<Picture> seen = DecodePicture(EncodePicture(clear, PictureType::Webp));
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->texels, clear.texels);
}

TEST(Picture, JpegComesBackNearly)
{
  for (const std::size_t components : { 1U, 3U })
  {
    Picture made{ 32, 16, components, Bytes(32 * 16 * components, 100) };
    const Result<Picture> read = DecodePicture(EncodePicture(made, PictureType::Jpeg));
    ASSERT_TRUE(read) << read.GetError().message;
    EXPECT_EQ(read->components, components);
    EXPECT_EQ(read->height, 16U);
    ASSERT_EQ(read->texels.size(), made.texels.size());
    for (const std::uint8_t value : read->texels)
    {
      EXPECT_NEAR(value, 100, 2);
    }
  }
}

TEST(Picture, PngOfOddKindsBecomesBytes)
{
  // 16 bits, big-endian.
  const Bytes deep = RawPng(2, 1, 16, PNG_COLOR_TYPE_GRAY, { 0x80, 0x80, 0xFF, 0xFF }, 4);
  ASSERT_TRUE(DecodePicture(deep)) << ErrorOf(deep);
  EXPECT_EQ(DecodePicture(deep)->texels, (Bytes{ 128, 255 }));
  const Bytes palette = RawPng(4, 1, 2, PNG_COLOR_TYPE_PALETTE, { 0x1B }, 1); // 0 1 2 3
  ASSERT_TRUE(DecodePicture(palette)) << ErrorOf(palette);
  EXPECT_EQ(DecodePicture(palette)->texels, (Bytes{ 1, 2, 3, 255, 0, 0, 0, 255, 0, 9, 8, 7 }));
  const Bytes bits = RawPng(8, 1, 1, PNG_COLOR_TYPE_GRAY, { 0xF0 }, 1);
  ASSERT_TRUE(DecodePicture(bits)) << ErrorOf(bits);
  EXPECT_EQ(DecodePicture(bits)->texels, (Bytes{ 255, 255, 255, 255, 0, 0, 0, 0 }));
  const Bytes alpha = RawPng(1, 1, 16, PNG_COLOR_TYPE_GRAY_ALPHA, { 0x40, 0x40, 0x20, 0x20 }, 4);
  ASSERT_TRUE(DecodePicture(alpha)) << ErrorOf(alpha);
  EXPECT_EQ(DecodePicture(alpha)->components, 2U);
  EXPECT_EQ(DecodePicture(alpha)->texels, (Bytes{ 0x40, 0x20 }));
}

TEST(Picture, CmykIsRefused)
{
  EXPECT_NE(ErrorOf(CmykJpeg()).find("CMYK"), std::string::npos);
}

TEST(Picture, WhatClaimsTooMuchTakesNoMemory)
{
  const Bytes one = RawPng(1, 1, 16, PNG_COLOR_TYPE_RGBA, Bytes(8), 8);
  const Bytes huge = PngClaiming(one, 60000, 60000);
  EXPECT_EQ(CodeOf(huge), ErrorCode::LimitExceeded);
  EXPECT_EQ(CodeOf(PngClaiming(one, 1U << 20, 1)), ErrorCode::LimitExceeded);
  const Picture small = Noise(20, 10, 3, 1);
  for (const PictureType type : { PictureType::Jpeg, PictureType::Png, PictureType::Webp })
  {
    const Bytes bytes = EncodePicture(small, type);
    EXPECT_EQ(CodeOf(bytes, 199), ErrorCode::LimitExceeded);
    EXPECT_EQ(ErrorOf(bytes, 200), "none");
  }
}

TEST(Picture, ScansWithoutEndAreRefused)
{
  const Bytes whole = ProgressiveJpeg();
  EXPECT_EQ(ErrorOf(whole), "none");
  // Repeats the last scan with its tables many times.
  std::size_t scan = whole.size() - 2;
  while (whole[scan] != 0xFF || whole[scan + 1] != 0xDA)
  {
    --scan;
  }
  Bytes many(whole.begin(), whole.end() - 2);
  for (int i = 0; i < 300; ++i)
  {
    many.insert(many.end(), whole.begin() + static_cast<std::ptrdiff_t>(scan), whole.end() - 2);
  }
  many.insert(many.end(), { 0xFF, 0xD9 });
  EXPECT_NE(ErrorOf(many).find("200 scans"), std::string::npos);
}

TEST(Picture, ThoseThatNeedAllTexelsAreKnownBefore)
{
  const Picture picture{ 5, 4, 3, std::vector<std::uint8_t>(60, 100) };
  EXPECT_TRUE(IsDecodedByRows(EncodePicture(picture, PictureType::Png)));
  EXPECT_TRUE(IsDecodedByRows(EncodePicture(picture, PictureType::Jpeg)));
  EXPECT_FALSE(IsDecodedByRows(EncodePicture(picture, PictureType::Webp)));
  EXPECT_FALSE(IsDecodedByRows(RawPng(2, 1, 8, PNG_COLOR_TYPE_RGB, Bytes(6), 6, true)));
  EXPECT_FALSE(IsDecodedByRows(ProgressiveJpeg()));
  Bytes cut = EncodePicture(picture, PictureType::Jpeg);
  for (; !cut.empty(); cut.pop_back())
  {
    static_cast<void>(IsDecodedByRows(cut)); // only for sanitizers
  }
  EXPECT_FALSE(IsDecodedByRows(cut));
}

// The rows that the first bytes give are delivered before the other bytes are read.
TEST(Picture, ALossyWebpComesRowByRow)
{
  class CountedRows : public PictureRows
  {
  public:
    bool Begin(std::size_t width, std::size_t, std::size_t components) override
    {
      this->Row = width * components;
      return true;
    }
    bool AddRow(const std::uint8_t* texels) override
    {
      this->Texels.insert(this->Texels.end(), texels, texels + this->Row);
      return true;
    }
    Status Why() const override { return {}; }

    std::size_t Row = 0;
    Bytes Texels;
  };
  Picture made = Noise(300, 900, 4, 12);
  for (std::size_t i = 0; i < made.texels.size(); ++i)
  {
    made.texels[i] = static_cast<std::uint8_t>(i / 1200 / 5 + made.texels[i] % 16);
  }
  const auto bytes = EncodeWebp(made, 90, false);
  ASSERT_TRUE(bytes);
  EXPECT_TRUE(IsDecodedByRows(*bytes));
  CountedRows all, first;
  ASSERT_TRUE(DecodePictureRows(*bytes, mostPicturePixels, all));
  ASSERT_EQ(all.Texels.size(), 3U * 300 * 900);
  for (std::size_t i = 0; i < all.Texels.size(); i += 3 * 50)
  {
    EXPECT_NEAR(all.Texels[i + 1], made.texels[i / 3 * 4 + 1], 40) << i;
  }
  const std::span<const std::uint8_t> half(bytes->data(), bytes->size() / 2);
  EXPECT_FALSE(DecodePictureRows(half, mostPicturePixels, first));
  const std::size_t rows = first.Texels.size() / first.Row;
  EXPECT_GT(rows, 100U);
  EXPECT_LT(rows, 700U);
  EXPECT_TRUE(std::equal(first.Texels.begin(), first.Texels.end(), all.Texels.begin()));
}

TEST(Picture, InterlacedOnesAreTheSame)
{
  const Picture made = Noise(23, 19, 3, 6);
  const Result<Picture> read =
    DecodePicture(RawPng(23, 19, 8, PNG_COLOR_TYPE_RGB, made.texels, std::size_t{ 3 } * 23, true));
  ASSERT_TRUE(read) << read.GetError().message;
  EXPECT_EQ(read->texels, made.texels);
}

TEST(Picture, CutOnesAreErrorsThatSayWhat)
{
  const Picture made = Noise(40, 30, 3, 3);
  for (const PictureType type : { PictureType::Jpeg, PictureType::Png, PictureType::Webp })
  {
    const Bytes whole = EncodePicture(made, type);
    ASSERT_EQ(ErrorOf(whole), "none");
    for (std::size_t percent = 2; percent < 98; percent += 5)
    {
      const Bytes cut(
        whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * percent / 100));
      EXPECT_NE(ErrorOf(cut).find("it is a damaged or truncated " + NameOf(type).substr(2)),
        std::string::npos)
        << percent << ": " << ErrorOf(cut);
    }
  }
  EXPECT_EQ(ErrorOf({}), "it is empty");
  EXPECT_EQ(ErrorOf({ 'G', 'I', 'F', '8' }), "it is neither JPEG, PNG nor WebP");
}

TEST(Picture, DamagedBytesNeverCrash)
{
  std::mt19937 random(7);
  const Picture made = Noise(24, 24, 3, 5);
  for (const PictureType type : { PictureType::Jpeg, PictureType::Png, PictureType::Webp })
  {
    const Bytes whole = EncodePicture(made, type);
    for (int round = 0; round < 300; ++round)
    {
      Bytes bytes = whole;
      for (unsigned count = 1 + random() % 4; count > 0; --count)
      {
        bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random() & 255U);
      }
      const Result<Picture> read = DecodePicture(bytes, 1 << 20);
      if (read)
      {
        EXPECT_EQ(read->texels.size(), read->width * read->height * read->components);
      }
    }
  }
}
