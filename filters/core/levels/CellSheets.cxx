// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CellSheets.h"

#include "filters/core/VectorMath.h"

#include <limits>

namespace kdstream
{
namespace
{

// Beyond so many components the smallest join at once: trying all pairs would take too long.
constexpr std::size_t mostPairs = 16;

Vec3 MeanOf(const Sheet& sheet)
{
  const auto n = static_cast<double>(sheet.count);
  return { sheet.sum[0] / n, sheet.sum[1] / n, sheet.sum[2] / n };
}

void JoinSheet(std::vector<Sheet>& sheets, std::size_t from, std::size_t to)
{
  sheets[from].joined = to;
  sheets[to].count += sheets[from].count;
  sheets[to].surface |= sheets[from].surface;
  for (std::size_t k = 0; k < 3; ++k)
  {
    sheets[to].sum[k] += sheets[from].sum[k];
  }
}

// All but the largest `most` join the nearest of these. separate: places in `sheets`, ascending.
void JoinSmallest(std::vector<Sheet>& sheets, std::vector<std::size_t>& separate, std::size_t most)
{
  std::sort(separate.begin(), separate.end(),
    [&](std::size_t a, std::size_t b)
    { return sheets[a].count != sheets[b].count ? sheets[a].count > sheets[b].count : a < b; });
  std::vector<Vec3> means;
  for (std::size_t i = 0; i < most; ++i)
  {
    means.push_back(MeanOf(sheets[separate[i]]));
  }
  for (std::size_t j = most; j < separate.size(); ++j)
  {
    const Vec3 own = MeanOf(sheets[separate[j]]);
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < most; ++i)
    {
      if (SquaredDistance(means[i], own) < SquaredDistance(means[nearest], own))
      {
        nearest = i;
      }
    }
    JoinSheet(sheets, separate[j], separate[nearest]);
  }
  separate.resize(most);
  std::sort(separate.begin(), separate.end());
}

// Of the smallest sheets the one that is nearest to another joins it.
void JoinNearest(std::vector<Sheet>& sheets, std::vector<std::size_t>& separate)
{
  std::uint64_t smallest = sheets[separate[0]].count;
  for (const std::size_t i : separate)
  {
    smallest = std::min(smallest, sheets[i].count);
  }
  double least = std::numeric_limits<double>::infinity();
  std::size_t from = separate[1], to = separate[0];
  for (const std::size_t i : separate)
  {
    for (const std::size_t j : separate)
    {
      const double distance = SquaredDistance(MeanOf(sheets[i]), MeanOf(sheets[j]));
      if (i != j && sheets[i].count == smallest && distance < least)
      {
        least = distance;
        from = i;
        to = j;
      }
    }
  }
  JoinSheet(sheets, from, to);
  separate.erase(std::find(separate.begin(), separate.end(), from));
}

}

void LimitSheets(std::vector<Sheet>& sheets)
{
  std::size_t loose = sheets.size();
  std::vector<std::size_t> separate;
  for (std::size_t i = 0; i < sheets.size(); ++i)
  {
    sheets[i].joined = i;
    if (sheets[i].surface || loose == sheets.size())
    {
      separate.push_back(i);
      loose = sheets[i].surface ? loose : i;
      continue;
    }
    JoinSheet(sheets, i, loose);
  }
  if (separate.size() > mostPairs)
  {
    JoinSmallest(sheets, separate, mostPairs);
  }
  while (separate.size() > mostSheets)
  {
    JoinNearest(sheets, separate);
  }
  for (Sheet& sheet : sheets)
  {
    while (sheets[sheet.joined].joined != sheet.joined) // what had joined one that joined
    {
      sheet.joined = sheets[sheet.joined].joined;
    }
  }
}

}
