// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/GeometricErrorBins.h"

#include "filters/core/BitCast.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kdstream
{

void GeometricErrorBins::Add(double geometricError)
{
  const auto value =
    static_cast<float>(std::min(geometricError, double(std::numeric_limits<float>::max())));
  ++this->Bins[BitCast<std::uint32_t>(value + 0.0F) >> shift]; // no -0.0
}

double GeometricErrorBins::Most99() const
{
  const std::uint64_t all =
    std::accumulate(this->Bins.begin(), this->Bins.end(), std::uint64_t{ 0 });
  if (all == 0)
  {
    return 0;
  }
  std::uint64_t before = (all - 1) * 99 / 100;
  std::uint32_t bin = 0;
  while (before >= this->Bins[bin])
  {
    before -= this->Bins[bin++];
  }
  return double(BitCast<float>(bin << shift));
}

}
