// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/CoarserState.h"

#include "filters/core/Light.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::size_t stateGrain = 1 << 14;

// Sets positions, geometric errors and lowest vertices.
void Place(const CollapseState& below, const Merging& merging, const CollapseSpace& space,
  Representative representative, std::span<const VertexId> standing, CollapseState& state,
  const Execution& execution)
{
  ClusterLevel& level = state.level;
  level.positions.resize(standing.size());
  level.geometricErrors.resize(standing.size());
  level.lowest.resize(standing.size());
  execution.parallelFor(standing.size(), stateGrain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        ClusterSum& cluster = state.clusters[i];
        const VertexId c = standing[i];
        switch (merging.PositionOf(c))
        {
          case Merging::Position::Kept:
            level.positions[i] = below.level.positions[c];
            break;
          case Merging::Position::Moved:
            level.positions[i] = space.Absolute(merging.MovedTo(c));
            break;
          case Merging::Position::Grouped:
            level.positions[i] = cluster.Represent(representative, space.origin);
            break;
        }
        cluster.geometricError = std::max(
          cluster.geometricError, cluster.GeometricErrorAt(space.Relative(level.positions[i])));
        level.geometricErrors[i] = cluster.geometricError;
        level.lowest[i] = cluster.lowest;
      }
    });
}

Vec3 LightOf(const VertexColor& color)
{
  const std::array<double, 256>& linear = LinearOfBytes();
  return { linear[color[0]], linear[color[1]], linear[color[2]] };
}

// Computes the colour of a coarser cluster, in linear light, from the colours that the triangles of
// its children have at its position. Children's colours limit the result.
class MergedColor
{
public:
  void AddChild(const VertexColor& color, std::uint64_t vertices)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Sums[k] += WholeLightOfBytes()[color[k]] * vertices;
      this->Least[k] = std::min(this->Least[k], color[k]);
      this->Most[k] = std::max(this->Most[k], color[k]);
    }
    this->Vertices += vertices;
  }
  void AddTriangle(const ColorQuadric& light, const Vec3& place)
  {
    if (light.area > 0)
    {
      this->Weighted = Plus(this->Weighted, Times(light.ColorAt(place), light.area));
      this->Area += light.area;
    }
  }
  // Clamped to the range of the children's colours; their mean if there are no triangles.
  VertexColor Color() const
  {
    VertexColor color{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double best = this->Weighted[k] / this->Area;
      const double mean = double(this->Sums[k]) / (double(this->Vertices) * wholeLight);
      color[k] =
        std::clamp(ByteOfLinear(std::isfinite(best) ? best : mean), this->Least[k], this->Most[k]);
    }
    return color;
  }

private:
  std::array<std::uint64_t, 3> Sums{};
  std::uint64_t Vertices = 0;
  VertexColor Least{ 255, 255, 255 }, Most{};
  Vec3 Weighted{};
  double Area = 0;
};

// The colours of a coarser level's clusters, whose positions are known, from the colours of the
// level below. parents: the parent of each own cluster.
std::vector<VertexColor> CoarserVertexColors(const CollapseState& below, const CollapseSpace& space,
  std::span<const VertexId> parents, const ClusterLevel& coarser)
{
  const std::vector<VertexColor>& colors = below.level.vertexColors;
  if (colors.empty())
  {
    return {};
  }
  std::vector<MergedColor> merged(coarser.positions.size());
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    merged[parents[i]].AddChild(colors[below.ownBegin + i], below.clusters[i].count);
  }
  const auto place = [&](VertexId c) { return space.Relative(below.level.positions[c]); };
  for (const Triangle& t : below.level.triangles)
  {
    const ColorQuadric light = ColorQuadric::OfTriangle({ place(t[0]), place(t[1]), place(t[2]) },
      { LightOf(colors[t[0]]), LightOf(colors[t[1]]), LightOf(colors[t[2]]) });
    for (const VertexId c : t)
    {
      if (below.IsOwn(c))
      {
        const VertexId parent = parents[c - below.ownBegin];
        merged[parent].AddTriangle(light, space.Relative(coarser.positions[parent]));
      }
    }
  }
  std::vector<VertexColor> vertexColors(merged.size());
  std::transform(merged.begin(), merged.end(), vertexColors.begin(),
    [](const MergedColor& color) { return color.Color(); });
  return vertexColors;
}

}

CollapseState MakeCoarser(const CollapseState& below, const Merging& merging,
  const CollapseSpace& space, Representative representative, std::vector<VertexId>& parents,
  const Execution& execution)
{
  CollapseState state;
  const std::vector<VertexId> standing = merging.Standing();
  std::vector<VertexId> number(below.OwnCount());
  for (std::size_t i = 0; i < standing.size(); ++i)
  {
    number[standing[i] - below.ownBegin] = static_cast<VertexId>(i);
    state.cellOf.push_back(merging.FinestCellOf(standing[i]));
  }
  parents.resize(number.size());
  state.clusters.resize(standing.size());
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    const auto c = static_cast<VertexId>(below.ownBegin + i);
    parents[i] = number[merging.StandsFor(c) - below.ownBegin];
    state.clusters[parents[i]].Add(below.clusters[i]);
  }
  Place(below, merging, space, representative, standing, state, execution);
  state.attributes =
    MeanOverChildren(below.attributes, below.clusters, parents, state.clusters.size());
  state.level.vertexColors = CoarserVertexColors(below, space, parents, state.level);
  state.ownEnd = static_cast<VertexId>(standing.size());
  return state;
}

}
