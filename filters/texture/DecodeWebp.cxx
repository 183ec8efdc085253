// SPDX-License-Identifier: BSD-3-Clause
// WebP by libwebp. Animations are refused.
#include "filters/texture/Picture.h"

#include <memory>

#include <webp/decode.h>

namespace kdstream
{

Status DecodeWebp(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
{
  const Error damaged{ ErrorCode::InvalidInput, "it is a damaged or truncated WebP" };
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes.data(), bytes.size(), &features) != VP8_STATUS_OK ||
      features.width <= 0 || features.height <= 0)
  {
    return damaged;
  }
  if (features.has_animation)
  {
    return Error{ ErrorCode::InvalidInput, "it is a WebP of several pictures" };
  }
  const auto width = static_cast<std::size_t>(features.width);
  const auto height = static_cast<std::size_t>(features.height);
  KDSTREAM_TRY(CheckPictureSize(width, height, mostPixels));
  const bool alpha = features.has_alpha != 0;
  const Picture head{ width, height, alpha ? 4U : 3U, {} };
  const std::size_t size = width * height * head.components;
  // Not touched before there are texels: a header by itself costs nothing.
  const auto texels = std::make_unique_for_overwrite<std::uint8_t[]>(size);
  const auto decode = alpha ? &WebPDecodeRGBAInto : &WebPDecodeRGBInto;
  // Its sides have 14 bits: a row fits an int.
  if (!decode(
        bytes.data(), bytes.size(), texels.get(), size, static_cast<int>(width * head.components)))
  {
    return damaged;
  }
  return TellRows(head, texels.get(), rows);
}

}
