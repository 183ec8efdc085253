// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/levels/FillTexels.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace kdstream
{
namespace
{

constexpr std::uint8_t emptyLevelTexel = 128;

using TexelSum = std::array<float, 5>; // of RGBA, and their number
struct TexelLayer
{
  std::size_t width = 1, height = 1;
  std::vector<TexelSum> sums;
};

// Fills the texels of a layer from the layer of half the size.
void FillLayer(TexelLayer& layer)
{
  if (layer.width == 1 && layer.height == 1)
  {
    return;
  }
  TexelLayer coarser;
  coarser.width = (layer.width + 1) / 2;
  coarser.height = (layer.height + 1) / 2;
  coarser.sums.resize(coarser.width * coarser.height);
  const auto above = [&](std::size_t i)
  { return i / layer.width / 2 * coarser.width + i % layer.width / 2; };
  for (std::size_t i = 0; i < layer.sums.size(); ++i)
  {
    for (std::size_t k = 0; k < 5; ++k)
    {
      coarser.sums[above(i)][k] += layer.sums[i][k];
    }
  }
  for (TexelSum& sum : coarser.sums)
  {
    for (std::size_t k = 0; k < 5 && sum[4] > 1; ++k)
    {
      sum[k] /= k < 4 ? sum[4] : 1;
    }
    sum[4] = std::min(sum[4], 1.0F);
  }
  FillLayer(coarser);
  for (std::size_t i = 0; i < layer.sums.size(); ++i)
  {
    layer.sums[i] = layer.sums[i][4] > 0 ? layer.sums[i] : coarser.sums[above(i)];
  }
}

}

void FillTexels(
  std::vector<std::uint8_t>& rgba, const std::vector<bool>& hasColor, std::int64_t width)
{
  TexelLayer finest;
  finest.width = static_cast<std::size_t>(width);
  finest.height = hasColor.size() / finest.width;
  for (std::size_t i = 0; i < hasColor.size(); ++i)
  {
    TexelSum sum{};
    for (std::size_t k = 0; k < 4 && hasColor[i]; ++k)
    {
      sum[k] = float(rgba[4 * i + k]);
    }
    sum[4] = hasColor[i] ? 1.0F : 0.0F;
    finest.sums.push_back(sum);
  }
  FillLayer(finest);
  for (std::size_t i = 0; i < hasColor.size(); ++i)
  {
    const TexelSum& sum = finest.sums[i];
    for (std::size_t k = 0; k < 4 && !hasColor[i]; ++k)
    {
      rgba[4 * i + k] =
        sum[4] > 0 ? static_cast<std::uint8_t>(sum[k] / sum[4] + 0.5F) : emptyLevelTexel;
    }
  }
}

}
