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

// Texels of `components` bytes: grey; grey and alpha; RGB; or RGBA. Rows go from top to bottom.
// sRGB.
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

// Tells the type by the first bytes, whatever the file's name is.
PictureType TypeOfPicture(std::span<const std::uint8_t> bytes);
// "a JPEG", "a PNG", "a WebP", "neither JPEG, PNG nor WebP".
std::string NameOf(PictureType type);
// Tells the type by the ending of the name, in any case; Unknown for other endings.
PictureType TypeOfName(const std::string& name);

// Whether decoding needs memory for only a few rows. An interlaced PNG, a progressive JPEG, and a
// WebP that is lossless or has alpha need all texels at once. Decides by the picture's headers;
// false for anything else.
bool IsDecodedByRows(std::span<const std::uint8_t> bytes);

inline constexpr std::uint64_t mostPicturePixels = std::uint64_t{ 1 } << 30;
// The most texels along a side. There is a limit because a single row takes memory, and the squares
// of TextureFolder.h are 64 rows high.
inline constexpr std::uint64_t mostPictureSide = std::uint64_t{ 1 } << 17;

// Decodes the picture according to its content. 16-bit channels become bytes; palettes become RGB
// or RGBA. Colours are taken as sRGB, whatever profile is embedded. mostPixels: for a picture that
// claims more pixels, no memory is allocated; for a smaller one, only as rows are decoded. Peak
// memory: the texels, and what the library needs: a few rows, or twice the texels for a progressive
// JPEG. Errors, without the file's name: LimitExceeded with the claimed size, or for lack of
// memory; InvalidInput for another format, a truncated or damaged picture, a JPEG in CMYK, or a
// JPEG with more scans than any program writes.
Result<Picture> DecodePicture(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels = mostPicturePixels);

// Receives a picture row by row, as it is decoded. False: it cannot take the row; Why has the
// reason.
class PictureRows
{
public:
  virtual ~PictureRows() = default;
  // Called once, before the rows.
  virtual bool Begin(std::size_t width, std::size_t height, std::size_t components) = 0;
  // Rows from top to bottom, of width × components bytes.
  virtual bool AddRow(const std::uint8_t* texels) = 0;
  virtual Status Why() const = 0;
};

// The same row by row. Peak memory: a row, and what the library needs. That is, for a lossy WebP,
// the rows that 16 kB of its bytes give; for a lossless WebP or an interlaced PNG, all texels.
// Errors: as above, possibly after some rows were delivered; those of rows.Why().
Status DecodePictureRows(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);

// One function for each format, for DecodePictureRows.

Status DecodeJpeg(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodePng(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
Status DecodeWebp(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows);
// For IsDecodedByRows. REQUIRES: PictureType::Webp.
bool IsWebpDecodedByRows(std::span<const std::uint8_t> bytes);

// Delivers all rows of a picture in memory. head: its size, without texels. Errors: rows.Why().
Status TellRows(const Picture& head, const std::uint8_t* texels, PictureRows& rows);

// The error if memory runs out.
Error NoMemoryForPixels();

// Checks that this number of pixels may be decoded. Errors: LimitExceeded with the size, also if a
// side is longer than mostPictureSide; InvalidInput for no pixels.
Status CheckPictureSize(std::uint64_t width, std::uint64_t height, std::uint64_t mostPixels);

}
