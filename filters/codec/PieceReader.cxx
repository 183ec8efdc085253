// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/PieceReader.h"

#include "filters/codec/AncestorTable.h"
#include "filters/codec/AttributePredictor.h"
#include "filters/codec/ByteStream.h"
#include "filters/codec/NumberingReader.h"
#include "filters/codec/PackedTriangles.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/PositionReader.h"
#include "filters/codec/Sorting.h"
#include "filters/core/SortTriangles.h"

#include <array>
#include <functional>
#include <memory>

namespace kdstream
{

const char* PieceReader::Read()
{
  if (!this->Walk.Read(this->Symbols, this->Shape.steps))
  {
    return "triangles out of range";
  }
  if (!(this->Grid.Lossless() ? this->ReadExactVertices() : this->ReadVertices<GridPredictor>()))
  {
    return "vertices out of range";
  }
  this->PlaceTriangles();
  if (!this->ReadOwnKeys() || !this->ReadAncestors() || !this->ReadChildNodes())
  {
    return "keys out of range";
  }
  for (std::size_t i = 0; i < this->Content.attributes.size(); ++i)
  {
    this->ReadAttribute(i);
  }
  return nullptr;
}

// Reads where the vertices are, and which numbers they have.
template <class Predictor>
bool PieceReader::ReadVertices()
{
  const std::size_t count = this->Shape.Vertices();
  const std::unique_ptr<typename Predictor::Point[]> points(new typename Predictor::Point[count]);
  this->Numbers.resize(count);
  this->Content.keys.resize(count);
  if (!this->ReadPoints<Predictor>(points.get()) ||
      !ReadGhosts(this->Symbols, this->Walk.Vertices(), this->Shape.counts.own, this->Content.keys,
        this->Numbers))
  {
    return false;
  }
  this->Content.positions.resize(count);
  for (std::size_t v = 0; v < count; ++v)
  {
    this->Content.positions[this->Numbers[v]] = Predictor::PositionOf(points[v], this->Grid);
  }
  return true;
}

bool PieceReader::ReadExactVertices()
{
  return this->ReadVertices<ExactPredictor>();
}

// Reads the points of all vertices, and the numbers of own ones. One loop both adds a vertex's
// difference to its prediction and reads its group: each task depends on its own earlier steps, but
// not on the other task, so a processor can do both at once.
template <class Predictor>
bool PieceReader::ReadPoints(typename Predictor::Point* points)
{
  using Point = typename Predictor::Point;
  using Differences = typename Predictor::Differences;
  const std::span<const WalkVertex> vertices = this->Walk.Vertices();
  PositionMode mode;
  if (!ReadPositionMode<Predictor>(this->Symbols, mode))
  {
    return false;
  }
  const std::unique_ptr<Differences[]> differences(new Differences[vertices.size()]);
  if (!ReadDifferences<Predictor>(this->Symbols, mode, vertices, differences.get()))
  {
    return false;
  }
  const Predictor predictor(this->Grid, mode.reach);
  const bool byPlanes = mode.tables == AxisTables::Plane;
  GroupReader groups(this->Symbols, vertices, this->Shape.counts.own);
  Point outside{};
  bool good = true;
  for (std::size_t v = 0; v < vertices.size() && good; ++v)
  {
    Differences difference = differences[v];
    if constexpr (Predictor::hasPlanes)
    {
      if (byPlanes && vertices[v].guided != 0)
      {
        difference = SurfacePlane(vertices[v], points).Decoded(difference);
      }
    }
    points[v] = predictor.At(Predicted(predictor, vertices, v, points), difference);
    predictor.Check(points[v], outside);
    good = vertices[v].own == 0 || groups.Read(v);
  }
  this->Symbols.Continue(groups.Position());
  if (!good || predictor.IsAny(outside))
  {
    return false;
  }
  NumberByGroup(
    groups.All(), this->Shape.counts.own,
    [=](std::uint32_t v) { return Predictor::SortKeyOf(points[v]); },
    [=](std::uint32_t v, std::uint32_t w)
    {
      const auto at = [=](std::uint32_t u) {
        return std::array{ points[u][0], points[u][1], points[u][2] };
      };
      return at(v) != at(w) ? at(v) < at(w) : v < w;
    },
    this->Numbers);
  return true;
}

// Converts the walk's triangles to the piece's numbers, and sorts them.
void PieceReader::PlaceTriangles()
{
  auto& triangles = this->Content.triangles;
  const std::span<const Triangle> walked = this->Walk.Triangles();
  const VertexId* numbers = this->Numbers.data();
  triangles.resize(walked.size());
  if (this->Shape.Vertices() <= std::size_t{ 1 } << PackedTriangles::bits)
  {
    PackedTriangles packed(walked.size(), this->Shape.Vertices());
    for (const auto& [a, b, c] : walked)
    {
      packed.Add(numbers[a], numbers[b], numbers[c]);
    }
    packed.Sort(triangles);
    return;
  }
  for (std::size_t t = 0; t < walked.size(); ++t)
  {
    const auto& [a, b, c] = walked[t];
    triangles[t] = RotateLowestFirst({ numbers[a], numbers[b], numbers[c] });
  }
  std::vector<Triangle> other;
  SortByMerging(triangles, other, std::less<>());
}

// Reads numbers of 0 … most, each stored as the difference from the previous one. Returns false if
// one is out of range.
bool PieceReader::ReadArray(
  std::size_t context, std::vector<std::uint64_t>& values, std::uint64_t most)
{
  std::uint64_t last = 0;
  for (std::uint64_t& value : values)
  {
    last += static_cast<std::uint64_t>(this->Symbols.Signed(context));
    if (last > most)
    {
      return false;
    }
    value = last;
  }
  return true;
}

// Original: nothing is stored; the keys are those of the partition from 0 on. Levels coarser than
// S: the first key is stored, the others are consecutive. Other levels: for each vertex the first
// vertex of its cluster's interval is stored.
bool PieceReader::ReadOwnKeys()
{
  const std::size_t own = this->Shape.counts.own;
  VertexKey* keys = this->Content.keys.data();
  if (this->Shape.IsBelowStitch() || this->Shape.IsOriginal())
  {
    const VertexKey first =
      this->Shape.IsOriginal()
        ? MakeKey(this->Shape.id.node - (NodeId{ 1 } << this->Shape.depths.partition), 0)
        : this->Symbols.Number(contexts::single);
    for (std::size_t v = 0; v < own; ++v)
    {
      keys[v] = first + v;
    }
    return first >> 32 == 0 || this->Shape.IsOriginal();
  }
  // Within a partition these first vertices ascend: each is stored as the number of vertices in
  // between.
  std::uint64_t partition = 0, index = 0; // the lowest key that the next vertex can have
  for (std::size_t v = 0; v < own; ++v)
  {
    const std::uint64_t further = this->Symbols.Number(contexts::ownPartition);
    index = (further > 0 ? 0 : index) + this->Symbols.Number(contexts::ownIndex);
    partition += further;
    if (further > noVertex || partition > noVertex || index > noVertex)
    {
      return false;
    }
    keys[v] = MakeKey(static_cast<std::uint32_t>(partition), static_cast<std::uint32_t>(index++));
  }
  return true;
}

// Reads ranks of parents level by level, fine to coarse: first the parent of each vertex, then the
// parent of each cluster that is an ancestor.
bool PieceReader::ReadAncestors()
{
  const AncestorShape shape = this->Shape.Ancestors();
  std::vector<std::uint32_t>& ranks = this->Content.ancestors;
  ranks.resize(shape.vertices * shape.levels);
  AncestorTable table(
    shape.vertices, shape.ofAll ? std::span(this->Content.triangles) : std::span<Triangle>());
  std::vector<std::uint32_t> parents;
  for (std::size_t level = shape.levels; level-- > 0;)
  {
    parents.resize(table.Count());
    SiblingGroups groups(parents.size());
    if (!this->ReadParents(level + 1 == shape.levels, table, parents, groups))
    {
      return false;
    }
    for (std::size_t v = 0; v < shape.vertices; ++v)
    {
      ranks[v * shape.levels + level] = parents[table.EntryOfVertex(v)];
    }
    table.Rise(parents, groups);
  }
  return true;
}

// ofVertices: whether entries are vertices, not clusters.
bool PieceReader::ReadParents(bool ofVertices, const AncestorTable& table,
  std::vector<std::uint32_t>& parents, SiblingGroups& groups)
{
  const std::size_t siblings = contexts::siblings + (ofVertices ? 0 : 4);
  RecentRanks recent;
  for (std::size_t entry = 0; entry < parents.size(); ++entry)
  {
    const SiblingGroups::Choices around = groups.Around(table.EarlierNeighboursOf(entry));
    const unsigned choice =
      around.count > 0 ? this->Symbols.Choice(siblings + around.Context()) : 0;
    if (choice > around.count)
    {
      return false;
    }
    if (choice > 0)
    {
      const std::uint32_t group = around.groups[choice - 1];
      groups.Join(entry, group);
      parents[entry] = parents[group];
      continue;
    }
    groups.Start(entry);
    if (!this->ReadRank(contexts::parentOf + (ofVertices ? 0 : 1), recent, parents[entry]))
    {
      return false;
    }
  }
  return true;
}

// Reads a parent's rank. Returns false if it is not a rank.
bool PieceReader::ReadRank(std::size_t context, RecentRanks& recent, std::uint32_t& parent)
{
  const unsigned symbol = this->Symbols.Choice(context);
  std::uint64_t rank = recent.Next();
  if (symbol == RecentRanks::other)
  {
    rank = recent.Newest() + static_cast<std::uint64_t>(this->Symbols.Signed(contexts::ancestor));
  }
  else if (symbol != RecentRanks::next && !recent.Find(symbol, rank))
  {
    return false;
  }
  if (rank >= noVertex)
  {
    return false;
  }
  recent.Use(symbol, rank);
  parent = static_cast<std::uint32_t>(rank);
  return true;
}

bool PieceReader::ReadChildNodes()
{
  if (!this->Shape.HasChildNodes())
  {
    return true;
  }
  std::vector<std::uint64_t> ends(this->Shape.counts.own), nodes(this->Shape.childNodes);
  if (!this->ReadArray(contexts::childEnd, ends, noVertex) ||
      !this->ReadArray(contexts::childNode, nodes, noVertex))
  {
    return false;
  }
  this->Content.childBegin.resize(ends.size() + 1);
  this->Content.childNodes.resize(nodes.size());
  for (std::size_t v = 0; v < ends.size(); ++v)
  {
    this->Content.childBegin[v + 1] = static_cast<std::uint32_t>(ends[v]);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    this->Content.childNodes[i] = static_cast<NodeId>(nodes[i]);
  }
  return true;
}

void PieceReader::ReadAttribute(std::size_t number)
{
  Attribute& attribute = this->Content.attributes[number];
  const bool ofVertices = attribute.association == AttributeAssociation::Point;
  const std::size_t tuples = ofVertices ? this->Shape.Vertices() : this->Shape.counts.triangles;
  const std::size_t size = SizeOf(attribute.type), tupleSize = attribute.TupleSize();
  const ComponentOrder order(attribute.type);
  AttributePredictor predictor(
    attribute, tuples, ofVertices ? this->Walk.Vertices() : std::span<const WalkVertex>());
  attribute.values.resize(tuples * tupleSize);
  const bool isCoarse = this->Shape.coarse[number] != 0;
  const std::uint64_t mask = isCoarse ? coarseMask : ~std::uint64_t{ 0 };
  const std::uint64_t step = isCoarse ? coarseStep : 1;
  std::uint64_t ofRed = 0;
  for (std::size_t t = 0; t < tuples; ++t)
  {
    std::uint8_t* to = attribute.values.data() + (ofVertices ? this->Numbers[t] : t) * tupleSize;
    for (std::size_t c = 0; c < attribute.components; ++c)
    {
      const std::int64_t difference = this->Symbols.Signed(contexts::attribute + number);
      const std::uint64_t value = predictor.Sum(predictor.Predict(t, c, ofRed), difference) & mask;
      ofRed = isCoarse && c == 0 ? static_cast<std::uint64_t>(difference) : ofRed;
      predictor.Set(t, c, value);
      const std::uint64_t bits = order.BitsOf(value) * step;
      for (std::size_t i = 0; i < size; ++i)
      {
        *to++ = static_cast<std::uint8_t>(bits >> (8 * i));
      }
    }
  }
}

}
