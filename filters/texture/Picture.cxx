// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/Picture.h"

#include "filters/meshio/FileEnding.h"

#include <algorithm>
#include <new>
#include <string_view>

namespace kdstream
{

PictureType TypeOfPicture(std::span<const std::uint8_t> bytes)
{
  const auto has = [&](std::size_t at, std::string_view text)
  {
    return bytes.size() >= at + text.size() &&
           std::equal(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
             [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
  };
  return has(0, "\xFF\xD8\xFF")             ? PictureType::Jpeg
         : has(0, "\x89PNG\r\n\x1A\n")      ? PictureType::Png
         : has(0, "RIFF") && has(8, "WEBP") ? PictureType::Webp
                                            : PictureType::Unknown;
}

bool IsDecodedByRows(std::span<const std::uint8_t> bytes)
{
  constexpr std::size_t interlacing = 28; // in the first chunk of a PNG
  constexpr std::uint8_t baseline = 0xC0, extended = 0xC1, scan = 0xDA;
  const PictureType type = TypeOfPicture(bytes);
  if (type == PictureType::Webp)
  {
    return IsWebpDecodedByRows(bytes);
  }
  if (type != PictureType::Jpeg)
  {
    return type == PictureType::Png && bytes.size() > interlacing && bytes[interlacing] == 0;
  }
  // A segment is 0xFF, a type, and a length that includes itself. Skips all segments before the
  // first frame.
  for (std::size_t at = 2; at + 4 <= bytes.size() && bytes[at] == 0xFF;)
  {
    const std::uint8_t segment = bytes[at + 1];
    if (segment == baseline || segment == extended)
    {
      return true;
    }
    const bool isFrame = segment > extended && segment <= 0xCF && segment != 0xC4 &&
                         segment != 0xC8 && segment != 0xCC;
    if (isFrame || segment == scan)
    {
      return false;
    }
    const bool isFill = segment == 0xFF;
    at += isFill ? 1 : 2 + (std::size_t{ bytes[at + 2] } << 8U | bytes[at + 3]);
  }
  return false;
}

std::string NameOf(PictureType type)
{
  switch (type)
  {
    case PictureType::Jpeg:
      return "a JPEG";
    case PictureType::Png:
      return "a PNG";
    case PictureType::Webp:
      return "a WebP";
    case PictureType::Unknown:
      break;
  }
  return "neither JPEG, PNG nor WebP";
}

PictureType TypeOfName(const std::string& name)
{
  const std::string ending = FileEnding(name);
  return ending == ".jpg" || ending == ".jpeg" ? PictureType::Jpeg
         : ending == ".png"                    ? PictureType::Png
         : ending == ".webp"                   ? PictureType::Webp
                                               : PictureType::Unknown;
}

Error NoMemoryForPixels()
{
  return { ErrorCode::LimitExceeded, "there is not enough memory for its pixels" };
}

Status CheckPictureSize(std::uint64_t width, std::uint64_t height, std::uint64_t mostPixels)
{
  if (width == 0 || height == 0)
  {
    return Error{ ErrorCode::InvalidInput, "it has no pixels" };
  }
  if (width > mostPixels / height)
  {
    return Error{ ErrorCode::LimitExceeded,
      "it claims " + std::to_string(width) + " x " + std::to_string(height) +
        " pixels, more than the limit of " + std::to_string(mostPixels) };
  }
  if (std::max(width, height) > mostPictureSide)
  {
    return Error{ ErrorCode::LimitExceeded, "it claims " + std::to_string(width) + " x " +
                                              std::to_string(height) + " pixels, more than " +
                                              std::to_string(mostPictureSide) + " along a side" };
  }
  return {};
}

namespace
{

// Collects the rows in memory.
class RowsOfPicture : public PictureRows
{
public:
  explicit RowsOfPicture(Picture& picture)
    : Into(picture)
  {
  }
  bool Begin(std::size_t width, std::size_t height, std::size_t components) override
  {
    this->Into = { width, height, components, {} };
    this->Into.texels.reserve(width * height * components); // pages are allocated only as rows come
    return true;
  }
  bool AddRow(const std::uint8_t* texels) override
  {
    const std::size_t row = this->Into.width * this->Into.components;
    this->Into.texels.insert(this->Into.texels.end(), texels, texels + row);
    return true;
  }
  Status Why() const override { return {}; }

private:
  Picture& Into;
};

Status DecodeKnown(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
{
  switch (TypeOfPicture(bytes))
  {
    case PictureType::Jpeg:
      return DecodeJpeg(bytes, mostPixels, rows);
    case PictureType::Png:
      return DecodePng(bytes, mostPixels, rows);
    case PictureType::Webp:
      return DecodeWebp(bytes, mostPixels, rows);
    case PictureType::Unknown:
      break;
  }
  return Error{ ErrorCode::InvalidInput,
    bytes.empty() ? "it is empty" : "it is " + NameOf(PictureType::Unknown) };
}

}

Result<Picture> DecodePicture(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels)
{
  Picture picture;
  RowsOfPicture rows(picture);
  KDSTREAM_TRY(DecodePictureRows(bytes, mostPixels, rows));
  return picture;
}

Status TellRows(const Picture& head, const std::uint8_t* texels, PictureRows& rows)
{
  bool goes = rows.Begin(head.width, head.height, head.components);
  for (std::size_t y = 0; goes && y < head.height; ++y)
  {
    goes = rows.AddRow(texels + y * head.width * head.components);
  }
  return goes ? Status{} : rows.Why();
}

Status DecodePictureRows(
  std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
{
  try
  {
    return DecodeKnown(bytes, mostPixels, rows);
  }
  catch (const std::bad_alloc&)
  {
    return NoMemoryForPixels();
  }
}

}
