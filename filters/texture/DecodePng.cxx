// SPDX-License-Identifier: BSD-3-Clause
// Decodes PNG by libpng. Steps: 1. the header: the size 2. the rows, as bytes, whatever their
// format.
#include "filters/texture/Picture.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <memory>

#include <png.h>

namespace kdstream
{
namespace
{

// The bytes that are left to read, and the error, if it is known.
struct PngInput
{
  std::span<const std::uint8_t> bytes;
  const char* why = "";
};

void ReadPng(png_structp codec, png_bytep to, std::size_t size)
{
  auto* const input = static_cast<PngInput*>(png_get_io_ptr(codec));
  if (size > input->bytes.size())
  {
    input->why = " (it ends too early)";
    png_error(codec, "");
  }
  std::memcpy(to, input->bytes.data(), size);
  input->bytes = input->bytes.subspan(size);
}

void OnPngError(png_structp codec, png_const_charp message)
{
  auto* const input = static_cast<PngInput*>(png_get_error_ptr(codec));
  input->why = std::strstr(message, "CRC")          ? " (a checksum does not fit)"
               : std::strstr(message, "Not enough") ? " (its texels end too early)"
                                                    : input->why;
  png_longjmp(codec, 1);
}

void OnPngWarning(png_structp, png_const_charp) {}

// No object with a destructor may live in the functions below, because longjmp can leave them.

bool ReadPngHeader(png_structp codec, png_infop info)
{
  if (setjmp(png_jmpbuf(codec)) != 0)
  {
    return false;
  }
  png_set_user_limits(codec, PNG_UINT_31_MAX, PNG_UINT_31_MAX); // our own limit applies
  png_set_chunk_malloc_max(codec, 1 << 24);                     // for profiles and texts
  png_read_info(codec, info);
  return true;
}

// Reserves the memory for rows.
bool AskForBytes(png_structp codec, png_infop info)
{
  if (setjmp(png_jmpbuf(codec)) != 0)
  {
    return false;
  }
  png_set_expand(codec); // palettes, fewer than 8 bits, transparent colours
  png_set_scale_16(codec);
  png_set_interlace_handling(codec); // each pass delivers all rows
  png_read_update_info(codec, info);
  return true;
}

// Decodes a picture that is not interlaced. row: memory for one row.
bool TellPngRows(png_structp codec, png_bytep row, std::size_t height, PictureRows& rows)
{
  if (setjmp(png_jmpbuf(codec)) != 0)
  {
    return false;
  }
  for (std::size_t y = 0; y < height; ++y)
  {
    png_read_row(codec, row, nullptr);
    if (!rows.AddRow(row))
    {
      return false;
    }
  }
  png_read_end(codec, nullptr);
  return true;
}

bool ReadPngRows(
  png_structp codec, png_bytep texels, std::size_t row, std::size_t height, int passes)
{
  if (setjmp(png_jmpbuf(codec)) != 0)
  {
    return false;
  }
  for (int pass = 0; pass < passes; ++pass)
  {
    for (std::size_t y = 0; y < height; ++y)
    {
      png_read_row(codec, texels + y * row, nullptr);
    }
  }
  png_read_end(codec, nullptr);
  return true;
}

class PngDecoder
{
public:
  explicit PngDecoder(std::span<const std::uint8_t> bytes)
    : Source{ bytes }
    , Codec(
        png_create_read_struct(PNG_LIBPNG_VER_STRING, &this->Source, &OnPngError, &OnPngWarning))
    , Info(this->Codec ? png_create_info_struct(this->Codec) : nullptr)
  {
  }
  ~PngDecoder() { png_destroy_read_struct(&this->Codec, &this->Info, nullptr); }
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;

  Status Decode(std::uint64_t mostPixels, PictureRows& rows)
  {
    if (!this->Codec || !this->Info)
    {
      return Error{ ErrorCode::LimitExceeded, "there is no memory for its decoder" };
    }
    png_set_read_fn(this->Codec, &this->Source, &ReadPng);
    if (!ReadPngHeader(this->Codec, this->Info))
    {
      return this->Failed();
    }
    Picture head{ png_get_image_width(this->Codec, this->Info),
      png_get_image_height(this->Codec, this->Info), 0, {} };
    KDSTREAM_TRY(CheckPictureSize(head.width, head.height, mostPixels));
    if (!AskForBytes(this->Codec, this->Info))
    {
      return this->Failed();
    }
    head.components = png_get_channels(this->Codec, this->Info);
    const std::size_t row = png_get_rowbytes(this->Codec, this->Info);
    if (row != head.width * head.components)
    {
      return Error{ ErrorCode::InvalidInput, "it is a PNG of an unknown kind" };
    }
    return png_get_interlace_type(this->Codec, this->Info) == PNG_INTERLACE_ADAM7
             ? this->DecodeInterlaced(head, row, rows)
             : this->DecodeRows(head, row, rows);
  }

private:
  Status DecodeRows(const Picture& head, std::size_t rowBytes, PictureRows& rows)
  {
    if (!rows.Begin(head.width, head.height, head.components))
    {
      return rows.Why();
    }
    std::vector<std::uint8_t> row(rowBytes);
    if (!TellPngRows(this->Codec, row.data(), head.height, rows))
    {
      KDSTREAM_TRY(rows.Why());
      return this->Failed();
    }
    return {};
  }

  // Every pass needs all rows. Memory of rows that never come is not touched.
  Status DecodeInterlaced(const Picture& head, std::size_t rowBytes, PictureRows& rows)
  {
    constexpr int passesOfAdam7 = 7;
    const auto texels = std::make_unique_for_overwrite<std::uint8_t[]>(rowBytes * head.height);
    return ReadPngRows(this->Codec, texels.get(), rowBytes, head.height, passesOfAdam7)
             ? TellRows(head, texels.get(), rows)
             : Status(this->Failed());
  }

  Error Failed() const
  {
    return { ErrorCode::InvalidInput,
      std::string("it is a damaged or truncated PNG") + this->Source.why };
  }

  PngInput Source;
  png_structp Codec = nullptr;
  png_infop Info = nullptr;
};

}

Status DecodePng(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
{
  return PngDecoder(bytes).Decode(mostPixels, rows);
}

}
