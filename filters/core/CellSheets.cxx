#include "filters/core/CellSheets.h"

namespace kdstream
{
namespace
{

double SquaredDistance(const Vec3& a, const Vec3& b)
{
  const Vec3 d{ a[0] - b[0], a[1] - b[1], a[2] - b[2] };
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
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
    sheets[i].joined = loose;
    sheets[loose].count += sheets[i].count;
    for (std::size_t k = 0; k < 3; ++k)
    {
      sheets[loose].sum[k] += sheets[i].sum[k];
    }
  }
  if (separate.size() <= mostSheets)
  {
    return;
  }
  std::sort(separate.begin(), separate.end(),
    [&](std::size_t a, std::size_t b)
    { return sheets[a].count != sheets[b].count ? sheets[a].count > sheets[b].count : a < b; });
  std::sort(separate.begin(), separate.begin() + mostSheets);
  const auto mean = [&](std::size_t i)
  {
    const auto n = static_cast<double>(sheets[i].count);
    return Vec3{ sheets[i].sum[0] / n, sheets[i].sum[1] / n, sheets[i].sum[2] / n };
  };
  for (std::size_t j = mostSheets; j < separate.size(); ++j)
  {
    const Vec3 own = mean(separate[j]);
    std::size_t nearest = separate[0];
    for (std::size_t i = 1; i < mostSheets; ++i)
    {
      if (SquaredDistance(mean(separate[i]), own) < SquaredDistance(mean(nearest), own))
      {
        nearest = separate[i];
      }
    }
    sheets[separate[j]].joined = nearest;
  }
  for (Sheet& sheet : sheets)
  {
    sheet.joined = sheets[sheet.joined].joined; // what had joined the loose ones follows them
  }
}

}
