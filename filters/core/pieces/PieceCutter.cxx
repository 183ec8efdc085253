// SPDX-License-Identifier: BSD-3-Clause
// Cutting one resolution into its pieces: see VertexTree.h and Piece.h. Step "cut" of the pipeline
// picture.
#include "filters/core/pieces/VertexTree.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{

ModelPart PartOfCell(Resolution resolution, const TreeDepths& depths, unsigned depth,
  std::size_t index, PrimitiveType primitive)
{
  const unsigned below = PieceDepth(resolution, depths) - depth;
  return { index << below, std::size_t{ 1 } << below, primitive };
}

PieceCutter::PieceCutter(const VertexTree& tree, const Mesh& mesh, Resolution resolution,
  const Execution& execution, const std::optional<ModelPart>& part)
  : Tree(tree)
  , Input(mesh)
  , Which(resolution)
{
  const auto primitive = mesh.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
  this->FindOwn(part ? *part : PartOfCell(resolution, tree.depths, 0, 0, primitive));
  if (resolution.IsOriginal())
  {
    this->PlaceMesh(execution);
  }
  this->FindTriangles(execution);
}

// Finds the pieces to cut, and where the own vertices of each begin.
void PieceCutter::FindOwn(const ModelPart& part)
{
  const unsigned depth = PieceDepth(this->Which, this->Tree.depths);
  const unsigned below = this->Tree.depths.partition - depth;
  this->Primitive = part.primitive;
  this->FirstNode = static_cast<NodeId>((std::size_t{ 1 } << depth) + part.firstPiece);
  const std::vector<VertexId>& numbers =
    this->Which.IsOriginal() ? this->Tree.numbers : this->Tree.levels[this->Which.Depth()].first;
  this->OwnBegin.resize(part.pieceCount + 1);
  for (std::size_t i = 0; i <= part.pieceCount; ++i)
  {
    const VertexId begin = this->Tree.partitionBegin[(part.firstPiece + i) << below];
    if (this->Which.IsOriginal() && numbers.empty())
    {
      // All vertices, or a part that has none.
      this->OwnBegin[i] = std::min(begin, static_cast<VertexId>(this->Tree.original.size()));
      continue;
    }
    this->OwnBegin[i] = static_cast<VertexId>(
      std::lower_bound(numbers.begin(), numbers.end(), begin) - numbers.begin());
  }
}

// Finds the place of each vertex of the mesh.
void PieceCutter::PlaceMesh(const Execution& execution)
{
  this->Places.resize(this->Tree.original.size());
  execution.parallelFor(this->Places.size(), 1 << 16,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        this->Places[this->Tree.original[i]] = static_cast<VertexId>(i);
      }
    });
}

// Finds the triangles of each piece.
void PieceCutter::FindTriangles(const Execution& execution)
{
  const bool original = this->Which.IsOriginal();
  this->Triangles =
    original ? this->Input.triangles : this->Tree.levels[this->Which.Depth()].triangles;
  const std::size_t places =
    original ? this->Tree.original.size() : this->Tree.levels[this->Which.Depth()].first.size();
  const std::size_t pieces = this->PieceCount();
  std::vector<std::uint32_t> pieceOf(places, static_cast<std::uint32_t>(pieces));
  for (std::size_t i = 0; i < pieces; ++i)
  {
    std::fill(pieceOf.data() + this->OwnBegin[i], pieceOf.data() + this->OwnBegin[i + 1],
      static_cast<std::uint32_t>(i));
  }
  this->Buckets = BucketTriangles(
    this->Triangles, pieces + 1, [&](VertexId v) { return pieceOf[this->PlaceOf(v)]; }, execution);
  this->OwnTriangles = this->Triangles.size();
  if (this->VertexCount() < places)
  {
    this->OwnTriangles =
      static_cast<std::size_t>(std::count_if(this->Triangles.begin(), this->Triangles.end(),
        [&](const Triangle& t)
        {
          return pieceOf[std::min(
                   { this->PlaceOf(t[0]), this->PlaceOf(t[1]), this->PlaceOf(t[2]) })] < pieces;
        }));
  }
}

// The numbered vertex at a place, or the lowest one of the cluster there.
VertexId PieceCutter::NumberedAt(VertexId place) const
{
  return this->Which.IsOriginal() ? this->Tree.NumberAt(place)
                                  : this->Tree.levels[this->Which.Depth()].first[place];
}

// near: the key of a vertex that is probably in the same partition, or 0.
VertexKey PieceCutter::KeyOf(VertexId place, VertexKey near) const
{
  return this->IsBelowStitch() ? this->Tree.levels[this->Which.Depth()].RankOf(place)
                               : this->Tree.KeyOf(this->NumberedAt(place), PartitionOfKey(near));
}

void PieceCutter::AppendVertex(VertexId place, Piece& piece) const
{
  piece.keys.push_back(this->KeyOf(place, piece.keys.empty() ? 0 : piece.keys.back()));
  piece.positions.push_back(this->Which.IsOriginal()
                              ? this->Input.points[this->Tree.original[place]]
                              : this->Tree.levels[this->Which.Depth()].positions[place]);
}

void PieceCutter::AppendAncestors(VertexId place, std::vector<std::uint32_t>& ranks) const
{
  const AncestorLevels above = AncestorLevelsOf(this->Which, this->Tree.depths);
  const std::size_t begin = ranks.size();
  ranks.resize(begin + above.count, 0);
  if (this->Tree.levels.empty() || above.count == 0)
  {
    return;
  }
  VertexId cluster =
    above.own ? place : this->Tree.ClusterAt(this->Tree.depths.stitch, this->NumberedAt(place));
  for (std::size_t k = above.count; k-- > 0;)
  {
    const std::size_t d = above.coarsest + k;
    cluster = this->Tree.levels[d + 1].parents[cluster];
    ranks[begin + k] = this->Tree.levels[d].RankOf(cluster);
  }
}

// Adds the child nodes of the own clusters [begin, end).
void PieceCutter::AddChildNodes(Piece& piece, VertexId begin, VertexId end) const
{
  piece.childBegin.assign(end - begin + 1, 0);
  const std::vector<ChildNode>& childNodes = this->Tree.levels[this->Which.Depth()].childNodes;
  auto entry = std::lower_bound(childNodes.begin(), childNodes.end(), ChildNode{ begin, 0 });
  for (; entry != childNodes.end() && entry->cluster < end; ++entry)
  {
    ++piece.childBegin[entry->cluster - begin + 1];
    piece.childNodes.push_back(entry->node);
  }
  for (std::size_t i = 0; i + 1 < piece.childBegin.size(); ++i)
  {
    piece.childBegin[i + 1] += piece.childBegin[i];
  }
}

Piece PieceCutter::Cut(std::size_t i) const
{
  const VertexId begin = this->OwnBegin[i], end = this->OwnBegin[i + 1];
  Piece piece;
  piece.id = { this->Which, static_cast<NodeId>(this->FirstNode + i) };
  piece.primitive = this->Primitive;
  piece.ownVertices = end - begin;

  const auto isOwn = [&](VertexId v) { return v >= begin && v < end; };
  std::vector<VertexId> ghosts;
  std::vector<std::pair<Triangle, std::uint32_t>> triangles; // with their numbers
  triangles.reserve(this->Buckets.Of(i).size());
  for (const std::uint32_t t : this->Buckets.Of(i))
  {
    const Triangle& triangle = this->Triangles[t];
    triangles.emplace_back(Triangle{ this->PlaceOf(triangle[0]), this->PlaceOf(triangle[1]),
                             this->PlaceOf(triangle[2]) },
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

  piece.keys.reserve(piece.ownVertices + ghosts.size());
  piece.positions.reserve(piece.ownVertices + ghosts.size());
  const bool carries = AncestorLevelsOf(this->Which, this->Tree.depths).own;
  for (VertexId v = begin; v < end; ++v)
  {
    this->AppendVertex(v, piece);
    if (carries)
    {
      this->AppendAncestors(v, piece.ancestors);
    }
    if (!this->Which.IsOriginal())
    {
      const double geometricError = this->Tree.levels[this->Which.Depth()].geometricErrors[v];
      piece.geometricErrors.push_back(
        static_cast<float>(std::min(geometricError, double(std::numeric_limits<float>::max()))));
    }
  }
  for (const VertexId ghost : ghosts)
  {
    this->AppendVertex(ghost, piece);
    this->AppendAncestors(ghost, piece.ancestors);
  }
  if (HasChildNodes(this->Which, this->Tree.depths))
  {
    this->AddChildNodes(piece, begin, end);
  }

  this->AddTriangles(piece, begin, ghosts, std::move(triangles));
  this->AddPointArrays(piece, begin, ghosts);
  return piece;
}

// Adds the triangles and their arrays. Equal triangles stay in the order of the input, so that each
// keeps its own tuples.
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
  // By how many corners each triangle was rotated.
  const auto turnOf = [&](const Triangle& turned, std::uint32_t number)
  {
    const Triangle& given = this->Triangles[number];
    std::size_t turn = 0;
    while (turn < 2 && local(this->PlaceOf(given[turn])) != turned[0])
    {
      ++turn;
    }
    // If the triangle has a vertex twice, both copies may come first.
    return turn == 0 && local(this->PlaceOf(given[1])) != turned[1] ? 2U : turn;
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
      const std::size_t third = IsOfCorners(array) ? array.TupleSize() / 3 : 0;
      for (const auto& [triangle, number] : sorted)
      {
        cut.Append(array, number);
        if (third > 0)
        {
          std::rotate(cut.values.end() - 3 * std::ptrdiff_t(third),
            cut.values.end() - std::ptrdiff_t((3 - turnOf(triangle, number)) * third),
            cut.values.end());
        }
      }
    }
  }
}

// Adds the point arrays, for own vertices from `begin` on and for the ghosts, before the cell
// arrays.
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
