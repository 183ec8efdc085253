// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/PartCollapse.h"

#include "filters/core/GhostCorners.h"

#include <algorithm>
#include <iterator>

namespace kdstream
{
namespace
{

// Parts collapse down to this share of their clusters, if necessary, so that there are enough
// merges for the threshold.
constexpr double deepest = 0.25;

}

PartTriangles::PartTriangles(
  const CollapseState& block, const BlockParts& parts, const Execution& execution)
  : begin(parts.count + 1, block.ownEnd)
{
  for (VertexId c = block.ownEnd; c-- > block.ownBegin;)
  {
    this->begin[parts.Of(block.cellOf[c - block.ownBegin])] = c;
  }
  for (std::size_t p = parts.count; p-- > 0;) // parts without clusters
  {
    this->begin[p] = std::min(this->begin[p], this->begin[p + 1]);
  }
  const std::size_t ghosts = parts.count; // a bucket that is never read
  this->buckets = BucketTriangles(
    block.level.triangles, parts.count + 1,
    [&](VertexId c)
    {
      const VertexId own = c - block.ownBegin; // huge if c is below the first own one
      return own < block.OwnCount() ? parts.Of(block.cellOf[own]) : ghosts;
    },
    execution);
}

PartCollapse::PartCollapse(const CollapseState& block, const CollapseSpace& space,
  const BlockParts& parts, std::size_t share, double areaPerVertex, const Execution& execution)
  : Block(block)
  , Space(space)
  , Share(share)
  , AreaPerVertex(areaPerVertex)
  , Exec(execution)
  , Of(block, parts, execution)
{
}

void PartCollapse::Collapse(
  std::span<const std::size_t> parts, double enough, std::span<MergeList> lists) const
{
  this->Exec.parallelFor(parts.size(), 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        lists[parts[i]] = this->MergesOf(parts[i], enough);
      }
    });
}

// The part's own clusters first, then those of other parts that the triangles touch.
CollapsePart PartCollapse::Extract(std::size_t p) const
{
  const std::vector<Triangle>& all = this->Block.level.triangles;
  const std::span<const std::uint32_t> triangles = this->Of.buckets.Of(p);
  const VertexId begin = this->Of.begin[p], end = this->Of.begin[p + 1], own = end - begin;
  CollapsePart part;
  part.triangles.reserve(triangles.size());
  std::transform(triangles.begin(), triangles.end(), std::back_inserter(part.triangles),
    [&](std::uint32_t t) { return all[t]; });
  const GhostCorners corners(part.triangles, begin, end);
  const std::vector<VertexId> ghosts = corners.Vertices();
  for (Triangle& t : part.triangles)
  {
    t = { t[0] - begin, t[1] - begin, t[2] - begin };
  }
  corners.ReplaceIn(
    part.triangles, [&](std::size_t ghost) { return own + static_cast<VertexId>(ghost); });
  part.components = this->Block.attributes.components;
  part.bounds = this->Space.RelativeBox();
  part.areaPerVertex = this->AreaPerVertex;
  part.positions.reserve(own + ghosts.size());
  part.quadrics.reserve(own + ghosts.size());
  part.normals.reserve(own + ghosts.size());
  for (VertexId c = begin; c < end; ++c)
  {
    AppendCluster(this->Block, this->Space, c, part);
  }
  std::transform(ghosts.begin(), ghosts.end(), std::back_inserter(part.positions),
    [&](VertexId ghost) { return this->Space.Relative(this->Block.level.positions[ghost]); });
  part.quadrics.resize(own + ghosts.size());
  part.normals.resize(own + ghosts.size());
  part.attributes.resize((own + ghosts.size()) * part.components);
  part.fixed.assign(own, 0);
  part.fixed.resize(own + ghosts.size(), 1);
  if (const std::span<const VertexColor> vertexColors = this->Block.level.vertexColors;
      !vertexColors.empty())
  {
    const auto ofOwn = vertexColors.subspan(begin, own);
    std::vector<VertexColor> colors(ofOwn.begin(), ofOwn.end());
    std::transform(ghosts.begin(), ghosts.end(), std::back_inserter(colors),
      [&](VertexId ghost) { return vertexColors[ghost]; });
    AddColorQuadrics(colors, own, GreyValue(DiagonalOf(this->Space.box)), part);
  }
  return part;
}

MergeList PartCollapse::MergesOf(std::size_t part, double enough) const
{
  EdgeCollapse engine(this->Extract(part));
  MergeList list;
  list.own = static_cast<std::uint32_t>(engine.VertexCount());
  const auto fewest = static_cast<std::size_t>(deepest * double(list.own));
  list.stuck =
    !engine.Run(std::max<std::size_t>(fewest, std::min<std::size_t>(list.own, this->Share)));
  if (!list.stuck)
  {
    const bool mayStop = engine.Merges().size() + this->Share >= list.own;
    list.stuck =
      !engine.RunBeyond(mayStop ? enough : std::numeric_limits<double>::infinity(), fewest);
  }
  list.whole = list.stuck || engine.VertexCount() <= fewest;
  list.merges = engine.Merges();
  const VertexId offset = this->Of.begin[part] - this->Block.ownBegin;
  for (Merge& merge : list.merges) // fixed clusters are in no merge
  {
    merge.from += offset;
    merge.to += offset;
  }
  return list;
}

}
