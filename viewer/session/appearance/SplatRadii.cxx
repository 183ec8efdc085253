// SPDX-License-Identifier: BSD-3-Clause
// How large the points of a cloud are drawn: see SplatRadii.h.
#include "viewer/session/appearance/SplatRadii.h"

#include "viewer/session/Geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::size_t longestRun = 64;
constexpr std::size_t shortestRun = 32; // a shorter run has no spacing of its own
constexpr std::size_t askedStride = 4;  // the neighbours of every fourth point are searched
constexpr std::size_t neighbour = 4;    // the distance to the fourth nearest counts
constexpr double radiusToSpacing = 0.82;

struct Run
{
  std::size_t begin = 0, end = 0;
  double spacing = 0.0;
};

// The distance from point `from` to its fourth nearest in the run; to the farthest if there are
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

// The mean of the smallest three quarters: where the order jumps to another side of the cloud, a
// few points of a run have no neighbours in it.
double SpacingOf(const Surface& cloud, const Run& run)
{
  std::vector<double> distances;
  for (std::size_t i = run.begin; i < run.end; i += askedStride)
  {
    distances.push_back(DistanceToNeighbour(cloud, run, i));
  }
  std::sort(distances.begin(), distances.end());
  const std::size_t taken = distances.size() - distances.size() / 4;
  const auto end = distances.begin() + static_cast<std::ptrdiff_t>(taken);
  return std::accumulate(distances.begin(), end, 0.0) / static_cast<double>(taken);
}

bool IsShort(const Run& run)
{
  return run.end - run.begin < shortestRun;
}

using RunsOfResolutions = std::map<Resolution, std::vector<Run>>;

// The runs, in the order of the points.
RunsOfResolutions FindRuns(const Surface& cloud)
{
  RunsOfResolutions all;
  for (std::size_t begin = 0, end = 0; begin < cloud.points.size(); begin = end)
  {
    const Resolution resolution = cloud.sources[begin].resolution;
    end = begin + 1;
    while (end < cloud.points.size() && end - begin < longestRun &&
           cloud.sources[end].resolution == resolution)
    {
      ++end;
    }
    all[resolution].push_back({ begin, end, 0.0 });
  }
  return all;
}

// Short runs have too few points for an estimate. They take the spacing of the run before them;
// short runs at the beginning take that of the run after them, which is near. If all runs are
// short, each uses its own estimate.
void FindSpacings(const Surface& cloud, std::vector<Run>& runs)
{
  const auto first = std::find_if_not(runs.begin(), runs.end(), IsShort);
  const bool allShort = first == runs.end();
  double last = allShort ? 0.0 : SpacingOf(cloud, *first);
  for (Run& run : runs)
  {
    last = IsShort(run) && !allShort ? last : SpacingOf(cloud, run);
    run.spacing = last;
  }
}

double MedianSpacing(const std::vector<Run>& runs)
{
  std::vector<double> spacings(runs.size());
  std::transform(
    runs.begin(), runs.end(), spacings.begin(), [](const Run& run) { return run.spacing; });
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
}

}

std::vector<float> SplatRadii(const Surface& cloud)
{
  std::vector<float> radii(cloud.points.size());
  for (auto& [resolution, runs] : FindRuns(cloud))
  {
    FindSpacings(cloud, runs);
    const double median = MedianSpacing(runs);
    for (const Run& run : runs)
    {
      const double spacing = std::clamp(run.spacing, 0.25 * median, 4.0 * median);
      std::fill(radii.begin() + static_cast<std::ptrdiff_t>(run.begin),
        radii.begin() + static_cast<std::ptrdiff_t>(run.end),
        static_cast<float>(radiusToSpacing * spacing));
    }
  }
  return radii;
}

std::vector<float> SplatRadii(const DrawnSurface& cloud)
{
  Surface all;
  for (const DrawnSurface::Part& each : cloud.Parts())
  {
    const Surface& part = each.part->surface;
    all.points.insert(all.points.end(), part.points.begin(), part.points.end());
    all.sources.insert(all.sources.end(), part.sources.begin(), part.sources.end());
  }
  return SplatRadii(all);
}

}
