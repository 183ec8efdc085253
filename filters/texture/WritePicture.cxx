// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/WritePicture.h"

#include "filters/texture/CompressJpeg.h"

#include <string>

#include <png.h>
#include <webp/encode.h>

namespace kdstream
{
namespace
{

std::vector<std::uint8_t> EncodeJpeg(const Picture& picture)
{
  constexpr int quality = 90;
  return CompressJpeg(
    picture.width, picture.height, picture.components,
    picture.components == 1 ? JCS_GRAYSCALE : JCS_RGB,
    [](jpeg_compress_struct& codec) { jpeg_set_quality(&codec, quality, TRUE); },
    [&picture](std::size_t number, std::vector<std::uint8_t>& row)
    {
      const auto from = picture.texels.begin() + static_cast<std::ptrdiff_t>(number * row.size());
      row.assign(from, from + static_cast<std::ptrdiff_t>(row.size()));
    });
}

std::vector<std::uint8_t> EncodePng(const Picture& picture)
{
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  constexpr png_uint_32 formats[] = { PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB,
    PNG_FORMAT_RGBA };
  image.format = formats[picture.components - 1];
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::uint8_t> bytes(size);
  png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.texels.data(), 0, nullptr);
  bytes.resize(size);
  return bytes;
}

std::vector<std::uint8_t> EncodeLosslessWebp(const Picture& picture)
{
  const bool grey = picture.components < 3, alpha = picture.components % 2 == 0;
  std::vector<std::uint8_t> wide;
  for (std::size_t i = 0; i < picture.texels.size(); i += picture.components)
  {
    const std::uint8_t* const texel = &picture.texels[i];
    wide.insert(wide.end(), { texel[0], texel[grey ? 0 : 1], texel[grey ? 0 : 2],
                              alpha ? texel[picture.components - 1] : std::uint8_t{ 255 } });
  }
  std::uint8_t* begin = nullptr;
  const auto width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
  const std::size_t size = WebPEncodeLosslessRGBA(wide.data(), width, height, 4 * width, &begin);
  std::vector<std::uint8_t> bytes(begin, begin + size);
  WebPFree(begin);
  return bytes;
}

}

std::vector<std::uint8_t> EncodePicture(const Picture& picture, PictureType type)
{
  return type == PictureType::Jpeg  ? EncodeJpeg(picture)
         : type == PictureType::Png ? EncodePng(picture)
                                    : EncodeLosslessWebp(picture);
}

Result<std::vector<std::uint8_t>> EncodeWebp(
  Picture picture, unsigned quality, bool alpha, int effort)
{
  const Error failed{ ErrorCode::LimitExceeded, "a picture of " + std::to_string(picture.width) +
                                                  " x " + std::to_string(picture.height) +
                                                  " texels cannot be encoded as WebP" };
  WebPConfig config;
  WebPPicture input;
  if (picture.width > WEBP_MAX_DIMENSION || picture.height > WEBP_MAX_DIMENSION ||
      !WebPConfigInit(&config) || !WebPPictureInit(&input))
  {
    return failed;
  }
  // For lossless pictures, `quality` is the effort.
  config.quality = quality == 0 ? 30.0F : float(quality);
  config.lossless = quality == 0;
  config.exact = 1;
  config.method = effort;
  input.use_argb = config.lossless;
  input.width = static_cast<int>(picture.width);
  input.height = static_cast<int>(picture.height);
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  input.writer = WebPMemoryWrite;
  input.custom_ptr = &writer;
  const int stride = 4 * input.width;
  const bool taken =
    (alpha ? WebPPictureImportRGBA : WebPPictureImportRGBX)(&input, picture.texels.data(), stride);
  std::vector<std::uint8_t>().swap(picture.texels); // libwebp has a copy
  const bool encoded = taken && WebPEncode(&config, &input);
  WebPPictureFree(&input);
  Result<std::vector<std::uint8_t>> bytes = failed;
  if (encoded)
  {
    bytes = std::vector<std::uint8_t>(writer.mem, writer.mem + writer.size);
  }
  WebPMemoryWriterClear(&writer);
  return bytes;
}

}
