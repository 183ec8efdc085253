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
// "a JPEG", "a PNG", "a WebP", "neither JPEG, PNG nor WebP".
std::string NameOf(PictureType type);
// By the ending of its name, in any case; Unknown for others.
PictureType TypeOfName(const std::string& name);

// Whether decoding needs memory for only a few rows: an interlaced PNG, a progressive JPEG, and a
// WebP that is lossless or has alpha need all texels at once. By the image's headers; false for
// anything else.
bool IsDecodedByRows(std::span<const std::uint8_t> bytes);

inline constexpr std::uint64_t mostPicturePixels = std::uint64_t{ 1 } << 30;
// Along a side: a row takes memory by itself, and the squares of TextureFolder.h are 64 rows high.
inline constexpr std::uint64_t mostPictureSide = std::uint64_t{ 1 } << 17;

// Decodes the picture by its content. 16-bit channels become bytes, palettes RGB or RGBA. Colours
// are taken as sRGB, whatever profile is embedded. mostPixels: no memory is taken for a picture
// that claims more; for a smaller one only as rows are decoded. Peak memory: the texels, and what
// the library needs: some rows, or twice the texels for a progressive JPEG. Errors, without the
// file's name: LimitExceeded with the claimed size, or for lack of memory; InvalidInput for another
// format, a truncated or damaged picture, a JPEG in CMYK, or one with more scans than any program
// writes.
Result<Picture> DecodePicture(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels = mostPicturePixels);

// Takes a picture as it is decoded. False: it cannot; it keeps the reason.
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

// The same row by row. Peak memory: a row, and what the library needs: for a lossy WebP the rows of
// 16 kB of its bytes; for a lossless one, and for an interlaced PNG, all texels. Errors: as above,
// possibly after some rows were delivered; those of rows.Why().
Status DecodePictureRows(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);

// One format each, for DecodePictureRows.

Status DecodeJpeg(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodePng(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodeWebp(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
// For IsDecodedByRows. REQUIRES: PictureType::Webp.
bool IsWebpDecodedByRows(std::span<const std::uint8_t> bytes);

// All rows of a picture in memory. head: its size, without texels. Errors: rows.Why().
Status TellRows(const Picture& head, const std::uint8_t* texels, PictureRows& rows);

// What is reported where memory runs out.
Error NoMemoryForPixels();

// Checks that this number of pixels may be decoded. Errors: LimitExceeded with the size, also if a
// side is longer than mostPictureSide; InvalidInput for no pixels.
Status CheckPictureSize(std::uint64_t width, std::uint64_t height, std::uint64_t mostPixels);

}
