// SPDX-License-Identifier: BSD-3-Clause
// Decodes JPEG by libjpeg-turbo. Steps: 1. the header: size and kind of colours 2. the rows.
#include "filters/texture/Picture.h"

#include <array>
#include <csetjmp>
#include <cstdio>

#include <jerror.h>
#include <jpeglib.h>

namespace kdstream
{
namespace
{

// libjpeg calls this on an error; it must not return.
struct Escape
{
  jpeg_error_mgr manager{};
  std::jmp_buf place{};
  std::array<char, 40> why{}; // our own message, if it says more than libjpeg's
  bool lacksMemory = false;
};

void OnJpegError(j_common_ptr codec)
{
  auto* const escape = reinterpret_cast<Escape*>(codec->err);
  const int code = codec->err->msg_code;
  escape->lacksMemory = code == JERR_OUT_OF_MEMORY;
  if (code == JERR_INPUT_EOF || code == JERR_INPUT_EMPTY || code == JWRN_JPEG_EOF)
  {
    std::snprintf(escape->why.data(), escape->why.size(), "it ends too early");
  }
  else if (code == JWRN_HIT_MARKER)
  {
    std::snprintf(escape->why.data(), escape->why.size(), "its texels end too early");
  }
  std::longjmp(escape->place, 1);
}

// Treats only warnings of damaged data as errors: after them, libjpeg would continue with grey. Odd
// headers, and bytes between the parts, are common in valid pictures.
void OnJpegMessage(j_common_ptr codec, int level)
{
  const int code = codec->err->msg_code;
  if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE))
  {
    OnJpegError(codec);
  }
}

// Each scan of a progressive JPEG is a pass over the whole picture, even if the scan has only a few
// bytes. Programs write about ten scans.
constexpr int mostScans = 200;

void OnJpegProgress(j_common_ptr codec)
{
  auto* const escape = reinterpret_cast<Escape*>(codec->err);
  if (reinterpret_cast<j_decompress_ptr>(codec)->input_scan_number > mostScans)
  {
    std::snprintf(escape->why.data(), escape->why.size(), "more than %d scans", mostScans);
    std::longjmp(escape->place, 1);
  }
}

// No object with a destructor may live in the functions below, because longjmp can leave them.

bool ReadJpegHeader(
  jpeg_decompress_struct& codec, Escape& escape, std::span<const std::uint8_t> bytes)
{
  if (setjmp(escape.place) != 0)
  {
    return false;
  }
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, bytes.data(), static_cast<unsigned long>(bytes.size()));
  return jpeg_read_header(&codec, TRUE) == JPEG_HEADER_OK;
}

// row: memory for one row.
bool ReadJpegRows(
  jpeg_decompress_struct& codec, Escape& escape, std::uint8_t* row, PictureRows& rows)
{
  if (setjmp(escape.place) != 0)
  {
    return false;
  }
  jpeg_start_decompress(&codec);
  while (codec.output_scanline < codec.output_height)
  {
    JSAMPROW at = row;
    jpeg_read_scanlines(&codec, &at, 1);
    if (!rows.AddRow(row))
    {
      return false;
    }
  }
  jpeg_finish_decompress(&codec);
  return true;
}

class JpegDecoder
{
public:
  JpegDecoder()
  {
    this->Codec.err = jpeg_std_error(&this->Leave.manager);
    this->Leave.manager.error_exit = &OnJpegError;
    this->Leave.manager.emit_message = &OnJpegMessage;
    this->Monitor.progress_monitor = &OnJpegProgress;
  }
  ~JpegDecoder() { jpeg_destroy_decompress(&this->Codec); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  Status Decode(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
  {
    if (!ReadJpegHeader(this->Codec, this->Leave, bytes))
    {
      return this->Failed();
    }
    KDSTREAM_TRY(CheckPictureSize(this->Codec.image_width, this->Codec.image_height, mostPixels));
    if (this->Codec.jpeg_color_space == JCS_CMYK || this->Codec.jpeg_color_space == JCS_YCCK)
    {
      return Error{ ErrorCode::InvalidInput,
        "it is a JPEG in CMYK, which is for print: save it in RGB" };
    }
    this->Codec.progress = &this->Monitor;
    const bool grey = this->Codec.jpeg_color_space == JCS_GRAYSCALE;
    this->Codec.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
    const std::size_t components = grey ? 1 : 3;
    if (!rows.Begin(this->Codec.image_width, this->Codec.image_height, components))
    {
      return rows.Why();
    }
    std::vector<std::uint8_t> row(this->Codec.image_width * components);
    if (!ReadJpegRows(this->Codec, this->Leave, row.data(), rows))
    {
      KDSTREAM_TRY(rows.Why());
      return this->Failed();
    }
    return {};
  }

private:
  Error Failed() const
  {
    if (this->Leave.lacksMemory)
    {
      return NoMemoryForPixels();
    }
    const std::string why = this->Leave.why.data();
    return { ErrorCode::InvalidInput,
      "it is a damaged or truncated JPEG" + (why.empty() ? why : " (" + why + ")") };
  }

  jpeg_decompress_struct Codec{};
  Escape Leave;
  jpeg_progress_mgr Monitor{};
};

}

Status DecodeJpeg(std::span<const std::uint8_t> bytes, std::uint64_t mostPixels, PictureRows& rows)
{
  return JpegDecoder().Decode(bytes, mostPixels, rows);
}

}
