// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/WritePicture.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

namespace kdstream
{
namespace
{

// Errors end the process: there is nothing wrong with what we made, and memory is all it takes.
std::vector<std::uint8_t> EncodeJpeg(const Picture& picture)
{
  constexpr int quality = 90;
  jpeg_compress_struct codec{};
  jpeg_error_mgr errors{};
  codec.err = jpeg_std_error(&errors);
  jpeg_create_compress(&codec);
  unsigned char* begin = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&codec, &begin, &size);
  codec.image_width = static_cast<JDIMENSION>(picture.width);
  codec.image_height = static_cast<JDIMENSION>(picture.height);
  codec.input_components = static_cast<int>(picture.components);
  codec.in_color_space = picture.components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  jpeg_start_compress(&codec, TRUE);
  std::vector<std::uint8_t> row(picture.width * picture.components);
  while (codec.next_scanline < codec.image_height)
  {
    const auto from =
      picture.texels.begin() + static_cast<std::ptrdiff_t>(codec.next_scanline * row.size());
    row.assign(from, from + static_cast<std::ptrdiff_t>(row.size()));
    JSAMPROW at = row.data();
    jpeg_write_scanlines(&codec, &at, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  std::vector<std::uint8_t> bytes(begin, begin + size);
  std::free(begin); // libjpeg took it so
  return bytes;
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

Result<std::vector<std::uint8_t>> EncodeWebp(const Picture& picture, unsigned quality, bool alpha)
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
  config.quality = quality == 0 ? 30.0F : float(quality); // of a lossless one: how hard it tries
  config.lossless = quality == 0;
  config.exact = 1;
  config.method = 2;
  input.use_argb = config.lossless;
  input.width = static_cast<int>(picture.width);
  input.height = static_cast<int>(picture.height);
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  input.writer = WebPMemoryWrite;
  input.custom_ptr = &writer;
  const int stride = 4 * input.width;
  const bool encoded = (alpha ? WebPPictureImportRGBA : WebPPictureImportRGBX)(
                         &input, picture.texels.data(), stride) &&
                       WebPEncode(&config, &input);
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
