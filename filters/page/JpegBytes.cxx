// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/JpegBytes.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <jpeglib.h>

namespace kdstream
{

namespace
{

// For libjpeg's errors: its error function must not return, so it jumps to `place`.
struct JpegEscape
{
  jpeg_error_mgr manager{};
  std::jmp_buf place{};
};

void LeaveJpeg(j_common_ptr codec)
{
  std::longjmp(reinterpret_cast<JpegEscape*>(codec->err)->place, 1);
}

// The bytes are allocated by malloc, even after a failure. No object here may have a destructor,
// because longjmp may leave this function.
bool CompressRows(std::span<const std::uint8_t> rgb, unsigned width, unsigned height,
  jpeg_compress_struct& codec, JpegEscape& escape, unsigned char*& begin, unsigned long& size)
{
  if (setjmp(escape.place) != 0)
  {
    return false;
  }
  jpeg_create_compress(&codec);
  jpeg_mem_dest(&codec, &begin, &size);
  codec.image_width = width;
  codec.image_height = height;
  codec.input_components = 3;
  codec.in_color_space = JCS_RGB;
  jpeg_set_defaults(&codec);
  constexpr int quality = 85;
  jpeg_set_quality(&codec, quality, TRUE);
  jpeg_start_compress(&codec, TRUE);
  while (codec.next_scanline < codec.image_height)
  {
    const std::size_t at = std::size_t{ codec.next_scanline } * width * 3;
    JSAMPROW row = const_cast<JSAMPROW>(&rgb[at]); // libjpeg only reads it
    jpeg_write_scanlines(&codec, &row, 1);
  }
  jpeg_finish_compress(&codec);
  return true;
}

}

Result<std::vector<std::uint8_t>> JpegBytes(
  std::span<const std::uint8_t> rgb, unsigned width, unsigned height)
{
  jpeg_compress_struct codec{};
  JpegEscape escape;
  codec.err = jpeg_std_error(&escape.manager);
  escape.manager.error_exit = LeaveJpeg;
  escape.manager.output_message = [](j_common_ptr) {};
  unsigned char* begin = nullptr;
  unsigned long size = 0;
  const bool isWhole = CompressRows(rgb, width, height, codec, escape, begin, size);
  jpeg_destroy_compress(&codec);
  const std::unique_ptr<unsigned char, decltype(&std::free)> bytes(begin, &std::free);
  if (!isWhole)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory for a picture" };
  }
  return std::vector<std::uint8_t>(begin, begin + size);
}

}
