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
  return "no JPEG, PNG or WebP";
}

PictureType TypeOfName(const std::string& name)
{
  const std::string ending = FileEnding(name);
  return ending == ".jpg" || ending == ".jpeg" ? PictureType::Jpeg
         : ending == ".png"                    ? PictureType::Png
         : ending == ".webp"                   ? PictureType::Webp
                                               : PictureType::Unknown;
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
  return {};
}

namespace
{

Result<Picture> DecodeKnown(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels)
{
  switch (TypeOfPicture(bytes))
  {
    case PictureType::Jpeg:
      return DecodeJpeg(bytes, mostPixels);
    case PictureType::Png:
      return DecodePng(bytes, mostPixels);
    case PictureType::Webp:
      return DecodeWebp(bytes, mostPixels);
    case PictureType::Unknown:
      break;
  }
  return Error{ ErrorCode::InvalidInput,
    bytes.empty() ? "it is empty" : "it is " + NameOf(PictureType::Unknown) };
}

}

Result<Picture> DecodePicture(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels)
{
  try
  {
    return DecodeKnown(bytes, mostPixels);
  }
  catch (const std::bad_alloc&)
  {
    return Error{ ErrorCode::LimitExceeded, "there is not enough memory for its pixels" };
  }
}

}
