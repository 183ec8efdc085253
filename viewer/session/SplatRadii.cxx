// SPDX-License-Identifier: BSD-3-Clause
// How large the points of a cloud are drawn: see SplatRadii.h.
#include "viewer/session/SplatRadii.h"

#include "viewer/session/Geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace kdstream
{
namespace
{

constexpr std::size_t longestRun = 64;
constexpr std::size_t askedStride =
  4;                                 // every so many points of a run are asked for their neighbours
constexpr std::size_t neighbour = 4; // which is the fourth nearest

struct Run
{
  std::size_t begin = 0, end = 0;
  double spacing = 0.0;
};

// The distance from point `from` to the fourth nearest of the run; to the farthest where there are
// fewer.
double DistanceToNeighbour(const Surface& cloud, const Run& run, std::size_t from)
{
  std::array<double, neighbour> nearest;
  nearest.fill(std::numeric_limits<double>::infinity());
  for (std::size_t i = run.begin; i < run.end; ++i)
  {
    if (i == from)
    {
      continue;
    }
    double distance = Length(cloud.points[i] - cloud.points[from]);
    for (double& kept : nearest)
    {
      if (distance < kept)
      {
        std::swap(kept, distance);
      }
    }
  }
  const std::size_t others = run.end - run.begin - 1;
  return others == 0 ? 0.0 : nearest[std::min(neighbour, others) - 1];
}

double SpacingOf(const Surface& cloud, const Run& run)
{
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = run.begin; i < run.end; i += askedStride, ++count)
  {
    sum += DistanceToNeighbour(cloud, run, i);
  }
  return sum / static_cast<double>(count);
}

std::vector<Run> RunsOf(const Surface& cloud)
{
  std::vector<Run> runs;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
  {
    const bool same = !runs.empty() && runs.back().end - runs.back().begin < longestRun &&
                      cloud.sources[i].resolution == cloud.sources[i - 1].resolution;
    if (!same)
    {
      runs.push_back({ i, i, 0.0 });
    }
    runs.back().end = i + 1;
  }
  for (Run& run : runs)
  {
    run.spacing = SpacingOf(cloud, run);
  }
  return runs;
}

// Of full runs; of all where none is full.
double MedianSpacing(const std::vector<Run>& runs, const Surface& cloud, Resolution resolution)
{
  std::vector<double> spacings;
  for (const bool full : { true, false })
  {
    for (const Run& run : runs)
    {
      const bool taken = !full || run.end - run.begin == longestRun;
      if (taken && cloud.sources[run.begin].resolution == resolution)
      {
        spacings.push_back(run.spacing);
      }
    }
    if (!spacings.empty())
    {
      break;
    }
  }
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
}

}

std::vector<float> SplatRadii(const Surface& cloud)
{
  std::vector<float> radii(cloud.points.size());
  const std::vector<Run> runs = RunsOf(cloud);
  // A surface has three resolutions at most: few medians are looked for.
  std::vector<std::pair<Resolution, double>> medians;
  for (const Run& run : runs)
  {
    const Resolution resolution = cloud.sources[run.begin].resolution;
    auto median = std::find_if(medians.begin(), medians.end(),
      [resolution](const auto& known) { return known.first == resolution; });
    if (median == medians.end())
    {
      medians.emplace_back(resolution, MedianSpacing(runs, cloud, resolution));
      median = medians.end() - 1;
    }
    const double spacing = std::clamp(run.spacing, 0.25 * median->second, 4.0 * median->second);
    std::fill(radii.begin() + static_cast<std::ptrdiff_t>(run.begin),
      radii.begin() + static_cast<std::ptrdiff_t>(run.end), static_cast<float>(0.75 * spacing));
  }
  return radii;
}

}
