// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/PackBoxes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kdstream
{
namespace
{

using Sizes = std::span<const std::array<std::int64_t, 2>>;

PackedBoxes PackShelves(Sizes sizes, const std::vector<std::size_t>& order, std::int64_t width)
{
  PackedBoxes packed{ 1, 1, std::vector<std::array<std::int64_t, 2>>(sizes.size()) };
  std::int64_t x = 0, y = 0, shelf = 0;
  for (const std::size_t box : order)
  {
    const auto [boxWidth, boxHeight] = sizes[box];
    if (x + boxWidth > width)
    {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    packed.places[box] = { x, y };
    x += boxWidth;
    shelf = std::max(shelf, boxHeight);
    packed.width = std::max(packed.width, x);
    packed.height = std::max(packed.height, y + shelf);
  }
  return packed;
}

}

std::optional<PackedBoxes> PackBoxes(Sizes sizes, std::int64_t mostSide)
{
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{ 0 });
  std::stable_sort(order.begin(), order.end(),
    [&](std::size_t a, std::size_t b)
    { return sizes[a][1] != sizes[b][1] ? sizes[a][1] > sizes[b][1] : sizes[a][0] > sizes[b][0]; });
  double area = 0;
  std::int64_t widest = 1;
  for (const auto& [width, height] : sizes)
  {
    area += double(width) * double(height);
    widest = std::max(widest, width);
  }
  if (widest > mostSide || area > double(mostSide) * double(mostSide))
  {
    return {};
  }
  std::optional<PackedBoxes> best;
  for (const double factor : { 0.75, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 1e9 })
  {
    const double wanted = std::min(std::sqrt(area) * factor, double(mostSide));
    PackedBoxes packed =
      PackShelves(sizes, order, std::max(widest, static_cast<std::int64_t>(wanted)));
    const bool fits = packed.height <= mostSide;
    if (fits && (!best || packed.width * packed.height < best->width * best->height))
    {
      best = std::move(packed);
    }
  }
  return best;
}

}
