// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/TilePictures.h"

#include "filters/store/Store.h"
#include "filters/texture/TexelSource.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kdstream
{
namespace
{

constexpr std::uint8_t emptyTexel = 128;

using Rgba = std::array<std::uint8_t, 4>;

Error DamagedTexture(const protocol::BlobId& blob, const std::string& what)
{
  return { ErrorCode::Damaged, BlobName(blob) + ": " + what };
}

// The index of the texel that is shown at a place along one side of a picture; nothing beyond a
// clamped edge.
std::optional<std::size_t> Wrapped(std::int64_t at, std::size_t size, std::uint8_t wrap)
{
  const auto side = static_cast<std::int64_t>(size);
  if (wrap == static_cast<std::uint8_t>(TextureWrap::Clamp))
  {
    return at >= 0 && at < side ? std::optional(static_cast<std::size_t>(at)) : std::nullopt;
  }
  const bool mirrors = wrap == static_cast<std::uint8_t>(TextureWrap::Mirror);
  const std::int64_t period = mirrors ? 2 * side : side;
  const std::int64_t inside = (at % period + period) % period;
  return static_cast<std::size_t>(inside < side ? inside : 2 * side - 1 - inside);
}

}

std::array<std::uint8_t, 4> TexelAt(const Picture& picture, std::int64_t x, std::int64_t y)
{
  const auto number = static_cast<std::size_t>(y) * picture.width + static_cast<std::size_t>(x);
  return RgbaOf(&picture.texels[number * picture.components], picture.components);
}

bool HasAlpha(const Picture& picture)
{
  for (std::size_t i = 3; picture.components == 4 && i < picture.texels.size(); i += 4)
  {
    if (picture.texels[i] != 255)
    {
      return true;
    }
  }
  return false;
}

std::vector<std::uint8_t> PngOf(Picture picture)
{
  bool opaque = picture.components == 4;
  for (std::size_t i = 3; opaque && i < picture.texels.size(); i += 4)
  {
    opaque = picture.texels[i] == 255;
  }
  if (opaque)
  {
    std::size_t to = 0;
    for (std::size_t i = 0; i < picture.texels.size(); i += 4, to += 3)
    {
      std::copy_n(
        picture.texels.begin() + std::ptrdiff_t(i), 3, picture.texels.begin() + std::ptrdiff_t(to));
    }
    picture.texels.resize(to);
    picture.components = 3;
  }
  return EncodePicture(picture, PictureType::Png);
}

Result<Picture> DecodeTileImage(const protocol::BlobId& blob, const TextureTile& tile)
{
  const std::uint64_t texels = std::uint64_t{ tile.width } * tile.height;
  Result<Picture> picture = DecodePicture(tile.image, texels);
  if (!picture)
  {
    return DamagedTexture(blob, picture.GetError().message);
  }
  if (picture->width != tile.width || picture->height != tile.height)
  {
    return DamagedTexture(blob, "its image does not have the size that the tile states");
  }
  return picture;
}

Picture GreyPicture(std::size_t width, std::size_t height)
{
  Picture picture{ width, height, 4, {} };
  picture.texels.assign(4 * width * height, emptyTexel);
  for (std::size_t i = 3; i < picture.texels.size(); i += 4)
  {
    picture.texels[i] = 255;
  }
  return picture;
}

void PasteTile(
  std::uint32_t number, const TextureTile& tile, const Picture& picture, Picture& canvas)
{
  const ExactTile& exact = tile.exact;
  std::vector<TexelBox> boxes(exact.charts.size()); // in the tile
  for (std::size_t t = 0; t < tile.corners.size(); ++t)
  {
    TexelBox& box = boxes[exact.chartOf[t]];
    for (const TileCoordinate& corner : tile.corners[t])
    {
      for (std::size_t k = 0; k < 2; ++k)
      {
        const auto least = static_cast<std::int64_t>(std::floor(corner[k])) - 1;
        const auto most = static_cast<std::int64_t>(std::ceil(corner[k])) + 1;
        const bool first = box.hi[k] == 0;
        box.lo[k] = first ? least : std::min(box.lo[k], least);
        box.hi[k] = first ? most : std::max(box.hi[k], most);
      }
    }
  }
  for (std::size_t c = 0; c < boxes.size(); ++c)
  {
    const TileChart& chart = exact.charts[c];
    if (chart.source == noTileSource || exact.sources[chart.source].picture != number)
    {
      continue;
    }
    const TexelBox& box = boxes[c];
    const auto& wrap = exact.sources[chart.source].wrap;
    for (std::int64_t y = std::max<std::int64_t>(box.lo[1], 0);
         y < std::min<std::int64_t>(box.hi[1], tile.height); ++y)
    {
      const auto row = Wrapped(y - chart.y, canvas.height, wrap[1]);
      for (std::int64_t x = std::max<std::int64_t>(box.lo[0], 0);
           row && x < std::min<std::int64_t>(box.hi[0], tile.width); ++x)
      {
        if (const auto column = Wrapped(x - chart.x, canvas.width, wrap[0]))
        {
          const Rgba texel = TexelAt(picture, x, y);
          std::copy(texel.begin(), texel.end(),
            canvas.texels.begin() + std::ptrdiff_t(4 * (*row * canvas.width + *column)));
        }
      }
    }
  }
}

}
