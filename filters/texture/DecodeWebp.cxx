// SPDX-License-Identifier: BSD-3-Clause
// Decodes WebP by libwebp, in bands: rows are delivered as their bytes are decoded, and their
// memory is then released. Animations are refused.
#include "filters/texture/Picture.h"

#include <algorithm>
#include <memory>

#include <sys/mman.h>
#include <webp/decode.h>

namespace kdstream
{
namespace
{

constexpr std::size_t bytesOfStep = 1 << 14; // of the file, for each band

// libwebp writes all rows into one buffer. The system allocates its pages only when they are
// written, so a mere header costs nothing. The pages of delivered rows are released.
class WebpTexels
{
public:
  explicit WebpTexels(std::size_t bytes)
    : Size(bytes)
    , Pages(::mmap(
        nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0))
  {
  }
  ~WebpTexels()
  {
    if (this->AreThere())
    {
      ::munmap(this->Pages, this->Size);
    }
  }
  WebpTexels(const WebpTexels&) = delete;
  WebpTexels& operator=(const WebpTexels&) = delete;

  bool AreThere() const { return this->Pages != MAP_FAILED; }
  std::uint8_t* Begin() const { return static_cast<std::uint8_t*>(this->Pages); }

  // Releases all bytes before `end`.
  void GiveBack(std::size_t end)
  {
    constexpr std::size_t atOnce = 1 << 20; // a multiple of every page size
    const std::size_t whole = end / atOnce * atOnce;
    if (whole > this->Given)
    {
      ::madvise(this->Begin() + this->Given, whole - this->Given, MADV_DONTNEED);
      this->Given = whole;
    }
  }

private:
  const std::size_t Size;
  void* const Pages;
  std::size_t Given = 0;
};

}

bool IsWebpDecodedByRows(std::span<const std::uint8_t> bytes)
{
  constexpr int lossy = 1;
  WebPBitstreamFeatures features;
  return WebPGetFeatures(bytes.data(), bytes.size(), &features) == VP8_STATUS_OK &&
         features.format == lossy && !features.has_alpha;
}

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
    return Error{ ErrorCode::InvalidInput, "it is a WebP with several pictures" };
  }
  const auto width = static_cast<std::size_t>(features.width);
  const auto height = static_cast<std::size_t>(features.height);
  KDSTREAM_TRY(CheckPictureSize(width, height, mostPixels));
  const std::size_t components = features.has_alpha != 0 ? 4 : 3, row = width * components;
  WebpTexels texels(row * height);
  if (!texels.AreThere())
  {
    return NoMemoryForPixels();
  }
  // The sides have 14 bits, so a row fits into an int.
  const std::unique_ptr<WebPIDecoder, void (*)(WebPIDecoder*)> decoder(
    WebPINewRGB(features.has_alpha != 0 ? MODE_RGBA : MODE_RGB, texels.Begin(), row * height,
      static_cast<int>(row)),
    &WebPIDelete);
  if (!decoder)
  {
    return NoMemoryForPixels();
  }
  if (!rows.Begin(width, height, components))
  {
    return rows.Why();
  }
  std::size_t handed = 0, end = 0; // delivered rows; bytes given to libwebp
  VP8StatusCode status = VP8_STATUS_SUSPENDED;
  while (status == VP8_STATUS_SUSPENDED && end < bytes.size())
  {
    end = std::min(end + bytesOfStep, bytes.size());
    status = WebPIUpdate(decoder.get(), bytes.data(), end);
    int decoded = 0;
    static_cast<void>(WebPIDecGetRGB(decoder.get(), &decoded, nullptr, nullptr, nullptr));
    for (; handed < static_cast<std::size_t>(decoded); ++handed)
    {
      if (!rows.AddRow(texels.Begin() + handed * row))
      {
        return rows.Why();
      }
    }
    texels.GiveBack(handed * row);
  }
  if (status == VP8_STATUS_OUT_OF_MEMORY)
  {
    return NoMemoryForPixels();
  }
  return status == VP8_STATUS_OK && handed == height ? Status{} : damaged;
}

}
