// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/TexelSource.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// A run of columns (or rows) of a box that are consecutive in the picture.
struct Run
{
  std::int64_t from = 0;  // the lowest column or row in the picture
  std::int64_t count = 0; // in the box; if step is 0, all are one texel
  int step = 1;           // -1: mirrored
};

std::int64_t FloorDivide(std::int64_t a, std::int64_t b)
{
  return a / b - (a % b < 0 ? 1 : 0);
}

std::vector<Run> RunsOf(std::int64_t begin, std::int64_t end, std::int64_t size, TextureWrap wrap)
{
  std::vector<Run> runs;
  while (begin < end)
  {
    const std::int64_t tile = FloorDivide(begin, size);
    const bool outside = wrap == TextureWrap::Clamp && tile != 0;
    const std::int64_t last = outside && tile > 0 ? end
                              : outside           ? std::min(end, std::int64_t{ 0 })
                                                  : std::min(end, (tile + 1) * size);
    const std::int64_t count = last - begin, at = begin - tile * size;
    if (outside)
    {
      runs.push_back({ tile < 0 ? 0 : size - 1, count, 0 });
    }
    else if (wrap == TextureWrap::Mirror && tile % 2 != 0)
    {
      runs.push_back({ size - at - count, count, -1 });
    }
    else
    {
      runs.push_back({ at, count, 1 });
    }
    begin = last;
  }
  return runs;
}

// The index, among the `count` texels that were read, of the run's i-th texel.
std::int64_t Place(const Run& run, std::int64_t i)
{
  return run.step == 0 ? 0 : run.step > 0 ? i : run.count - 1 - i;
}

// Copies the part of an RGBA row that was read into the box.
void CopyRun(const Run& columns, const std::uint8_t* line, std::uint8_t* to)
{
  if (columns.step > 0)
  {
    std::copy_n(line, 4 * columns.count, to);
    return;
  }
  for (std::int64_t i = 0; i < columns.count; ++i, to += 4)
  {
    std::copy_n(line + 4 * Place(columns, i), 4, to);
  }
}

}

Result<std::vector<std::uint8_t>> ReadWrapped(const TexelSource& source, std::uint32_t picture,
  const TexelBox& box, TextureWrap wrapU, TextureWrap wrapV)
{
  const auto size = source.SizeOf(picture);
  const std::vector<Run> columns = RunsOf(box.lo[0], box.hi[0], size[0], wrapU);
  const std::vector<Run> rows = RunsOf(box.lo[1], box.hi[1], size[1], wrapV);
  std::vector<std::uint8_t> texels(static_cast<std::size_t>(4 * box.Width() * box.Height()));
  std::vector<std::uint8_t> part;
  std::int64_t y = 0;
  for (const Run& row : rows)
  {
    std::int64_t x = 0;
    for (const Run& column : columns)
    {
      const std::int64_t width = column.step == 0 ? 1 : column.count;
      const std::int64_t height = row.step == 0 ? 1 : row.count;
      part.resize(static_cast<std::size_t>(4 * width * height));
      KDSTREAM_TRY(source.Read(picture,
        { { column.from, row.from }, { column.from + width, row.from + height } }, part.data()));
      for (std::int64_t j = 0; j < row.count; ++j)
      {
        CopyRun(column, part.data() + 4 * width * Place(row, j),
          texels.data() + 4 * ((y + j) * box.Width() + x));
      }
      x += column.count;
    }
    y += row.count;
  }
  return texels;
}

std::array<std::uint32_t, 2> PicturesInMemory::SizeOf(std::uint32_t picture) const
{
  const Picture& p = this->Pictures[picture];
  return p.texels.empty() ? std::array<std::uint32_t, 2>{}
                          : std::array{ static_cast<std::uint32_t>(p.width),
                              static_cast<std::uint32_t>(p.height) };
}

Status PicturesInMemory::Read(std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const
{
  const Picture& p = this->Pictures[picture];
  for (auto y = static_cast<std::size_t>(box.lo[1]); y < std::size_t(box.hi[1]); ++y)
  {
    for (auto x = static_cast<std::size_t>(box.lo[0]); x < std::size_t(box.hi[0]); ++x)
    {
      const auto texel = RgbaOf(&p.texels[(y * p.width + x) * p.components], p.components);
      rgba = std::copy(texel.begin(), texel.end(), rgba);
    }
  }
  return {};
}

}
