// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CellComponents.h"

#include "filters/core/VectorMath.h"

#include <limits>

namespace kdstream
{
namespace
{

// If there are more components than this, the smallest are joined at once: trying all pairs would
// take too long.
constexpr std::size_t mostPairs = 16;

Vec3 MeanOf(const CellComponent& component)
{
  const auto n = static_cast<double>(component.count);
  return { component.sum[0] / n, component.sum[1] / n, component.sum[2] / n };
}

void JoinComponent(std::vector<CellComponent>& components, std::size_t from, std::size_t to)
{
  components[from].joined = to;
  components[to].count += components[from].count;
  components[to].surface |= components[from].surface;
  for (std::size_t k = 0; k < 3; ++k)
  {
    components[to].sum[k] += components[from].sum[k];
  }
}

// All but the `most` largest components join the nearest of these. separate: places in
// `components`, ascending.
void JoinSmallest(
  std::vector<CellComponent>& components, std::vector<std::size_t>& separate, std::size_t most)
{
  std::sort(separate.begin(), separate.end(),
    [&](std::size_t a, std::size_t b)
    {
      return components[a].count != components[b].count ? components[a].count > components[b].count
                                                        : a < b;
    });
  std::vector<Vec3> means;
  for (std::size_t i = 0; i < most; ++i)
  {
    means.push_back(MeanOf(components[separate[i]]));
  }
  for (std::size_t j = most; j < separate.size(); ++j)
  {
    const Vec3 own = MeanOf(components[separate[j]]);
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < most; ++i)
    {
      if (SquaredDistance(means[i], own) < SquaredDistance(means[nearest], own))
      {
        nearest = i;
      }
    }
    JoinComponent(components, separate[j], separate[nearest]);
  }
  separate.resize(most);
  std::sort(separate.begin(), separate.end());
}

// Among the smallest components, the one that is nearest to another component joins it.
void JoinNearest(std::vector<CellComponent>& components, std::vector<std::size_t>& separate)
{
  std::uint64_t smallest = components[separate[0]].count;
  for (const std::size_t i : separate)
  {
    smallest = std::min(smallest, components[i].count);
  }
  double least = std::numeric_limits<double>::infinity();
  std::size_t from = separate[1], to = separate[0];
  for (const std::size_t i : separate)
  {
    for (const std::size_t j : separate)
    {
      const double distance = SquaredDistance(MeanOf(components[i]), MeanOf(components[j]));
      if (i != j && components[i].count == smallest && distance < least)
      {
        least = distance;
        from = i;
        to = j;
      }
    }
  }
  JoinComponent(components, from, to);
  separate.erase(std::find(separate.begin(), separate.end(), from));
}

}

void LimitComponents(std::vector<CellComponent>& components)
{
  std::size_t loose = components.size();
  std::vector<std::size_t> separate;
  for (std::size_t i = 0; i < components.size(); ++i)
  {
    components[i].joined = i;
    if (components[i].surface || loose == components.size())
    {
      separate.push_back(i);
      loose = components[i].surface ? loose : i;
      continue;
    }
    JoinComponent(components, i, loose);
  }
  if (separate.size() > mostPairs)
  {
    JoinSmallest(components, separate, mostPairs);
  }
  while (separate.size() > mostCellComponents)
  {
    JoinNearest(components, separate);
  }
  for (CellComponent& component : components)
  {
    // The component that it was joined to may have been joined to another one.
    while (components[component.joined].joined != component.joined)
    {
      component.joined = components[component.joined].joined;
    }
  }
}

}
