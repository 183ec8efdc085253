// SPDX-License-Identifier: BSD-3-Clause
// Pictures as bytes of texels: JPEG, PNG and WebP. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Bytes, `components` a texel: grey; grey and alpha; RGB; RGBA. Rows from the top down. sRGB.
struct Picture
{
  std::size_t width = 0, height = 0; // at least 1
  std::size_t components = 3;        // 1-4
  std::vector<std::uint8_t> texels;
};

// The texel of any picture as RGBA.
inline std::array<std::uint8_t, 4> RgbaOf(const std::uint8_t* texel, std::size_t components)
{
  const bool grey = components < 3;
  return { texel[0], texel[grey ? 0 : 1], texel[grey ? 0 : 2],
    components % 2 == 0 ? texel[components - 1] : std::uint8_t{ 255 } };
}

enum class PictureType
{
  Unknown,
  Jpeg,
  Png,
  Webp
};

// By its first bytes, whatever its name.
PictureType TypeOfPicture(std::span<const std::uint8_t> bytes);
// "a JPEG", "a PNG", "a WebP", "no JPEG, PNG or WebP".
std::string NameOf(PictureType type);
// By the ending of its name, in any case; Unknown for others.
PictureType TypeOfName(const std::string& name);

// Whether decoding it takes memory only for a few rows: of a WebP, an interlaced PNG and a
// progressive JPEG all texels are needed at a time. By its headers; false for what is none.
bool IsDecodedByRows(std::span<const std::uint8_t> bytes);

inline constexpr std::uint64_t mostPicturePixels = std::uint64_t{ 1 } << 30;
// Along a side: a row takes memory by itself, and the squares of TextureFolder.h are 64 rows high.
inline constexpr std::uint64_t mostPictureSide = std::uint64_t{ 1 } << 17;

// Decodes the picture by what it is. 16-bit channels become bytes, palettes RGB or RGBA. Colours
// are taken as sRGB whatever profile is embedded. mostPixels: no memory is taken for a picture that
// claims more, and of less only for rows that are there. Peak memory: the texels, and what the
// library needs: rows, of a progressive JPEG twice the texels again.
// Errors, without the file's name: LimitExceeded with the size that is claimed, or where there is
// no memory; InvalidInput for what is none of the three, truncated, damaged, a JPEG in CMYK or of
// more scans than any program writes.
Result<Picture> DecodePicture(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels = mostPicturePixels);

// Who takes a picture as it is decoded. False: it cannot; it keeps why.
class PictureRows
{
public:
  virtual ~PictureRows() = default;
  // Once, before the rows.
  virtual bool Begin(std::size_t width, std::size_t height, std::size_t components) = 0;
  // From above down, width × components bytes.
  virtual bool AddRow(const std::uint8_t* texels) = 0;
  virtual Status Why() const = 0;
};

// The same row by row. Peak memory: a row, and what the library needs; but of an interlaced PNG and
// of a WebP the texels. Errors: as above, when some rows may have been told; rows.Why().
Status DecodePictureRows(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);

// One format each, for DecodePictureRows.

Status DecodeJpeg(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodePng(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodeWebp(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);

// All rows of a picture in memory. head: its size, without texels. Errors: rows.Why().
Status TellRows(const Picture& head, const std::uint8_t* texels, PictureRows& rows);

// What is reported where memory runs out.
Error NoMemoryForPixels();

// Whether so many pixels may be decoded. Errors: LimitExceeded with the size, also where a side is
// longer than mostPictureSide; InvalidInput for none.
Status CheckPictureSize(std::uint64_t width, std::uint64_t height, std::uint64_t mostPixels);

}
