// SPDX-License-Identifier: BSD-3-Clause
// Makes a JPEG in memory by libjpeg, for WritePicture and for the odd pictures of tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>

namespace kdstream
{

// prepare(codec): sets properties of the JPEG other than its size and colours; defaults are already
// set. fill(number, row): fills the samples of a row, `components` for each pixel.
//
// Errors end the process: our input is always valid, so the only cause is lack of memory.
template <class Prepare, class Fill>
std::vector<std::uint8_t> CompressJpeg(std::size_t width, std::size_t height,
  std::size_t components, J_COLOR_SPACE colors, const Prepare& prepare, const Fill& fill)
{
  jpeg_compress_struct codec{};
  jpeg_error_mgr errors{};
  codec.err = jpeg_std_error(&errors);
  jpeg_create_compress(&codec);
  unsigned char* begin = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&codec, &begin, &size);
  codec.image_width = static_cast<JDIMENSION>(width);
  codec.image_height = static_cast<JDIMENSION>(height);
  codec.input_components = static_cast<int>(components);
  codec.in_color_space = colors;
  jpeg_set_defaults(&codec);
  prepare(codec);
  jpeg_start_compress(&codec, TRUE);
  std::vector<std::uint8_t> row(width * components);
  while (codec.next_scanline < codec.image_height)
  {
    fill(std::size_t{ codec.next_scanline }, row);
    JSAMPROW at = row.data();
    jpeg_write_scanlines(&codec, &at, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  std::vector<std::uint8_t> bytes(begin, begin + size);
  std::free(begin); // libjpeg has allocated it by malloc
  return bytes;
}

}
