// Cutting one resolution into its pieces: see VertexTree.h and Piece.h. Step "cut" of the README's
// picture.
#include "filters/core/VertexTree.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{

PieceCutter::PieceCutter(
  const VertexTree& tree, const Mesh& mesh, Resolution resolution, const Execution& execution)
  : Tree(tree)
  , Input(mesh)
  , Which(resolution)
{
  const unsigned depth = PieceDepth(resolution, tree.depths);
  const std::size_t pieces = std::size_t{ 1 } << depth;
  const unsigned below = tree.depths.partition - depth;
  this->OwnBegin.resize(pieces + 1);
  for (std::size_t i = 0; i <= pieces; ++i)
  {
    const VertexId begin = tree.partitionBegin[i << below];
    if (resolution.IsOriginal())
    {
      this->OwnBegin[i] = begin;
      continue;
    }
    const std::vector<VertexId>& first = tree.levels[resolution.Depth()].first;
    this->OwnBegin[i] =
      static_cast<VertexId>(std::lower_bound(first.begin(), first.end(), begin) - first.begin());
  }
  if (resolution.IsOriginal())
  {
    this->Number.resize(tree.original.size());
    execution.parallelFor(this->Number.size(), 1 << 16,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          this->Number[tree.original[i]] = static_cast<VertexId>(i);
        }
      });
    this->Triangles = mesh.triangles;
  }
  else
  {
    this->Triangles = tree.levels[resolution.Depth()].triangles;
  }
  std::vector<std::uint32_t> pieceOf(this->OwnBegin.back());
  for (std::size_t i = 0; i < pieces; ++i)
  {
    std::fill(pieceOf.data() + this->OwnBegin[i], pieceOf.data() + this->OwnBegin[i + 1],
      static_cast<std::uint32_t>(i));
  }
  this->Buckets = BucketTriangles(
    this->Triangles, pieces, [&](VertexId v) { return pieceOf[this->NumberOf(v)]; }, execution);
  if (resolution < Resolution::Level(tree.depths.stitch))
  {
    this->FindReach();
  }
}

VertexKey PieceCutter::KeyOf(VertexId vertex) const
{
  if (this->Which.IsOriginal())
  {
    return this->Tree.KeyOf(vertex);
  }
  if (this->Which.Depth() < this->Tree.depths.stitch)
  {
    return vertex;
  }
  return this->Tree.KeyOf(this->Tree.levels[this->Which.Depth()].first[vertex]);
}

void PieceCutter::AppendVertex(VertexId vertex, Piece& piece) const
{
  piece.keys.push_back(this->KeyOf(vertex));
  piece.positions.push_back(this->Which.IsOriginal()
                              ? this->Input.points[this->Tree.original[vertex]]
                              : this->Tree.levels[this->Which.Depth()].positions[vertex]);
}

void PieceCutter::AppendAncestors(VertexId vertex, std::vector<std::uint32_t>& ranks) const
{
  const unsigned stitch = this->Tree.depths.stitch;
  if (this->Tree.levels.empty())
  {
    ranks.resize(ranks.size() + stitch, 0);
    return;
  }
  VertexId numbered = vertex;
  if (!this->Which.IsOriginal())
  {
    numbered = this->Tree.levels[this->Which.Depth()].first[vertex];
  }
  VertexId cluster = this->Tree.ClusterAt(stitch, numbered);
  const std::size_t begin = ranks.size();
  ranks.resize(begin + stitch);
  for (unsigned d = stitch; d-- > 0;)
  {
    cluster = this->Tree.levels[d + 1].parents[cluster];
    ranks[begin + d] = cluster;
  }
}

// For every cluster of a level below S the nodes of the level-S pieces that hold its descendants.
void PieceCutter::FindReach()
{
  const TreeDepths& depths = this->Tree.depths;
  const VertexTreeLevel& stitch = this->Tree.levels[depths.stitch];
  const unsigned nodeDepth = PieceDepth(Resolution::Level(depths.stitch), depths);
  for (VertexId cluster = 0; cluster < stitch.first.size(); ++cluster)
  {
    VertexId ancestor = cluster;
    for (unsigned d = depths.stitch; d > this->Which.Depth(); --d)
    {
      ancestor = this->Tree.levels[d].parents[ancestor];
    }
    const std::uint32_t partition = this->Tree.PartitionOf(stitch.first[cluster]);
    this->Reach.emplace_back(
      ancestor, NodeOfPartition(partition, depths) >> (depths.partition - nodeDepth));
  }
  std::sort(this->Reach.begin(), this->Reach.end());
  this->Reach.erase(std::unique(this->Reach.begin(), this->Reach.end()), this->Reach.end());
}

// Of the own clusters [begin, end).
void PieceCutter::AddReach(Piece& piece, VertexId begin, VertexId end) const
{
  piece.reachBegin.assign(end - begin + 1, 0);
  auto entry =
    std::lower_bound(this->Reach.begin(), this->Reach.end(), std::pair{ begin, NodeId{ 0 } });
  for (; entry != this->Reach.end() && entry->first < end; ++entry)
  {
    ++piece.reachBegin[entry->first - begin + 1];
    piece.reachNodes.push_back(entry->second);
  }
  for (std::size_t i = 0; i + 1 < piece.reachBegin.size(); ++i)
  {
    piece.reachBegin[i + 1] += piece.reachBegin[i];
  }
}

Piece PieceCutter::Cut(std::size_t i) const
{
  const TreeDepths& depths = this->Tree.depths;
  const VertexId begin = this->OwnBegin[i], end = this->OwnBegin[i + 1];
  Piece piece;
  piece.id = { this->Which, static_cast<NodeId>(this->PieceCount() + i) };
  piece.primitive =
    this->Input.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
  piece.ownVertices = end - begin;

  const auto isOwn = [&](VertexId v) { return v >= begin && v < end; };
  std::vector<VertexId> ghosts;
  std::vector<std::pair<Triangle, std::uint32_t>> triangles; // and their numbers
  triangles.reserve(this->Buckets.Of(i).size());
  for (const std::uint32_t t : this->Buckets.Of(i))
  {
    const Triangle& triangle = this->Triangles[t];
    triangles.emplace_back(Triangle{ this->NumberOf(triangle[0]), this->NumberOf(triangle[1]),
                             this->NumberOf(triangle[2]) },
      t);
    for (const VertexId v : triangles.back().first)
    {
      if (!isOwn(v))
      {
        ghosts.push_back(v);
      }
    }
  }
  std::sort(ghosts.begin(), ghosts.end());
  ghosts.erase(std::unique(ghosts.begin(), ghosts.end()), ghosts.end());

  const bool carries = !this->Which.IsOriginal() && this->Which.Depth() == depths.stitch;
  for (VertexId v = begin; v < end; ++v)
  {
    this->AppendVertex(v, piece);
    if (carries)
    {
      this->AppendAncestors(v, piece.ancestors);
    }
    if (!this->Which.IsOriginal())
    {
      const double deviation = this->Tree.levels[this->Which.Depth()].deviations[v];
      piece.deviations.push_back(
        static_cast<float>(std::min(deviation, double(std::numeric_limits<float>::max()))));
    }
  }
  const bool belowStitch = this->Which < Resolution::Level(depths.stitch);
  for (const VertexId ghost : ghosts)
  {
    this->AppendVertex(ghost, piece);
    if (!belowStitch)
    {
      this->AppendAncestors(ghost, piece.ancestors);
    }
  }
  if (belowStitch)
  {
    this->AddReach(piece, begin, end);
  }

  this->AddTriangles(piece, begin, ghosts, std::move(triangles));
  this->AddPointArrays(piece, begin, ghosts);
  return piece;
}

// The triangles and their arrays; triangles that are equal stay in the order of the input, so that
// each keeps its own tuples.
void PieceCutter::AddTriangles(Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts,
  std::vector<std::pair<Triangle, std::uint32_t>>&& triangles) const
{
  const auto local = [&](VertexId v)
  {
    return v >= begin && v - begin < piece.ownVertices
             ? v - begin
             : static_cast<VertexId>(
                 std::lower_bound(ghosts.begin(), ghosts.end(), v) - ghosts.begin()) +
                 piece.ownVertices;
  };
  for (auto& [triangle, number] : triangles)
  {
    triangle = RotateLowestFirst({ local(triangle[0]), local(triangle[1]), local(triangle[2]) });
  }
  std::vector<std::pair<Triangle, std::uint32_t>> sorted(triangles.size());
  std::vector<std::uint32_t> next;
  SortByTriangle(std::span<const std::pair<Triangle, std::uint32_t>>(triangles), 0,
    piece.VertexCount(), std::span(sorted), next);
  piece.triangles.reserve(sorted.size());
  for (const auto& [triangle, number] : sorted)
  {
    piece.triangles.push_back(triangle);
  }
  if (!this->Which.IsOriginal())
  {
    return;
  }
  for (const Attribute& array : this->Input.attributes)
  {
    if (array.association == AttributeAssociation::Cell)
    {
      Attribute& cut = piece.attributes.emplace_back(Attribute{ array.Info(), {} });
      cut.values.reserve(sorted.size() * array.TupleSize());
      for (const auto& [triangle, number] : sorted)
      {
        cut.Append(array, number);
      }
    }
  }
}

// Of the own vertices from `begin` on and the ghosts. They come before the cell arrays.
void PieceCutter::AddPointArrays(
  Piece& piece, VertexId begin, const std::vector<VertexId>& ghosts) const
{
  const bool original = this->Which.IsOriginal();
  const std::vector<Attribute>& arrays =
    original ? this->Input.attributes : this->Tree.levels[this->Which.Depth()].attributes;
  const auto tupleOf = [&](VertexId v) { return original ? this->Tree.original[v] : v; };
  std::vector<Attribute> cut;
  for (const Attribute& array : arrays)
  {
    if (array.association != AttributeAssociation::Point)
    {
      continue;
    }
    Attribute& points = cut.emplace_back(Attribute{ array.Info(), {} });
    points.values.reserve(piece.VertexCount() * array.TupleSize());
    for (VertexId v = begin; v < begin + piece.ownVertices; ++v)
    {
      points.Append(array, tupleOf(v));
    }
    for (const VertexId ghost : ghosts)
    {
      points.Append(array, tupleOf(ghost));
    }
  }
  piece.attributes.insert(piece.attributes.begin(), std::make_move_iterator(cut.begin()),
    std::make_move_iterator(cut.end()));
}

}
