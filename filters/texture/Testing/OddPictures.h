// SPDX-License-Identifier: BSD-3-Clause
// Pictures that our own writer does not make: PNGs of all kinds, JPEGs in CMYK and in scans,
// headers that claim more than the file holds.
#pragma once

#include "filters/texture/CompressJpeg.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <png.h>

namespace kdstream::test
{

using Bytes = std::vector<std::uint8_t>;

// A PNG of any depth and colour type, with rows of `row` bytes each, packed as libpng packs them. A
// palette is (1, 2, 3), red, green, (9, 8, 7), blue. alphas: of its first colours.
inline Bytes RawPng(unsigned width, unsigned height, int depth, int type, Bytes rows,
  std::size_t row, bool interlaced = false, Bytes alphas = {})
{
  Bytes bytes;
  png_structp codec = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(codec);
  png_set_write_fn(
    codec, &bytes,
    [](png_structp writer, png_bytep data, std::size_t size)
    {
      auto* const to = static_cast<Bytes*>(png_get_io_ptr(writer));
      to->insert(to->end(), data, data + size);
    },
    nullptr);
  png_set_IHDR(codec, info, width, height, depth, type,
    interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
    PNG_FILTER_TYPE_DEFAULT);
  const std::array<png_color, 5> palette{ { { 1, 2, 3 }, { 255, 0, 0 }, { 0, 255, 0 }, { 9, 8, 7 },
    { 0, 0, 255 } } };
  if (type == PNG_COLOR_TYPE_PALETTE)
  {
    png_set_PLTE(codec, info, palette.data(), std::min(int(palette.size()), 1 << depth));
  }
  if (!alphas.empty())
  {
    png_set_tRNS(codec, info, alphas.data(), int(alphas.size()), nullptr);
  }
  png_write_info(codec, info);
  std::vector<png_bytep> begins;
  for (unsigned y = 0; y < height; ++y)
  {
    begins.push_back(&rows[y * row]);
  }
  png_write_image(codec, begins.data());
  png_write_end(codec, info);
  png_destroy_write_struct(&codec, &info);
  return bytes;
}

// A mid-grey picture of 8 x 8.
inline Bytes CmykJpeg()
{
  return CompressJpeg(
    8, 8, 4, JCS_CMYK, [](jpeg_compress_struct&) {},
    [](std::size_t, Bytes& row) { std::fill(row.begin(), row.end(), std::uint8_t{ 100 }); });
}

// A mid-grey picture of 64 x 32, in scans.
inline Bytes ProgressiveJpeg()
{
  return CompressJpeg(
    64, 32, 3, JCS_RGB, [](jpeg_compress_struct& codec) { jpeg_simple_progression(&codec); },
    [](std::size_t, Bytes& row) { std::fill(row.begin(), row.end(), std::uint8_t{ 100 }); });
}

// The PNG with another size in its header, and a correct checksum.
inline Bytes PngClaiming(Bytes png, std::uint32_t width, std::uint32_t height)
{
  const auto put = [&](std::size_t at, std::uint32_t value)
  {
    for (std::size_t k = 0; k < 4; ++k)
    {
      png[at + k] = static_cast<std::uint8_t>(value >> (24 - 8 * k));
    }
  };
  put(16, width);
  put(20, height);
  std::uint32_t crc = 0xFFFFFFFFU; // of PNG chunks
  for (std::size_t i = 12; i < 29; ++i)
  {
    crc ^= png[i];
    for (int bit = 0; bit < 8; ++bit)
    {
      crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
  }
  put(29, ~crc);
  return png;
}

// The JPEG with another size in its header.
inline Bytes JpegClaiming(Bytes jpeg, unsigned width, unsigned height)
{
  for (std::size_t i = 0; i + 8 < jpeg.size(); ++i)
  {
    if (jpeg[i] == 0xFF && (jpeg[i + 1] == 0xC0 || jpeg[i + 1] == 0xC2))
    {
      const auto put = [&](std::size_t at, unsigned value)
      {
        jpeg[at] = static_cast<std::uint8_t>(value >> 8);
        jpeg[at + 1] = static_cast<std::uint8_t>(value & 255U);
      };
      put(i + 5, height);
      put(i + 7, width);
      break;
    }
  }
  return jpeg;
}

// A WebP of 16383 x 16383 that consists of only a header.
inline Bytes WebpOfNothing()
{
  return { 'R', 'I', 'F', 'F', 36, 0, 0, 0, 'W', 'E', 'B', 'P', 'V', 'P', '8', 'L', 24, 0, 0, 0,
    0x2F, 0xFE, 0xBF, 0xFF, 0x0F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 };
}

}
