// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/PieceWriter.h"

#include "filters/codec/AncestorTable.h"
#include "filters/codec/AttributePredictor.h"
#include "filters/codec/ByteStream.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/RecentRanks.h"

#include <algorithm>
#include <memory>

namespace kdstream
{

void PieceWriter::Write()
{
  this->Walk.Write(this->Symbols);
  if (this->Grid.Lossless())
  {
    this->WriteVertices<ExactPredictor>();
  }
  else
  {
    this->WriteVertices<GridPredictor>();
  }
  this->WriteOwnKeys();
  this->WriteAncestors();
  this->WriteChildNodes();
  for (std::size_t i = 0; i < this->Content.attributes.size(); ++i)
  {
    this->WriteAttribute(i);
  }
}

// Writes where the vertices are, and which numbers they have.
template <class Predictor>
void PieceWriter::WriteVertices()
{
  const std::span<const WalkVertex> vertices = this->Walk.Vertices();
  const std::vector<VertexId>& numbers = this->Walk.Numbers();
  const std::unique_ptr<typename Predictor::Point[]> points(
    new typename Predictor::Point[vertices.size()]);
  std::vector<Vec3> coordinates(vertices.size()); // of the points, as comparable numbers
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    const auto point = Predictor::PointOf(this->Content.positions[numbers[v]], this->Grid);
    points[v] = point;
    coordinates[v] = { double(point[0]), double(point[1]), double(point[2]) };
  }
  // Not for partitions: they are most of what a desktop draws, and decoding by planes takes a tenth
  // longer.
  const bool mayUsePlanes = !this->Shape.IsOriginal();
  WritePositions<Predictor>(this->Symbols, this->Grid, vertices, points.get(), mayUsePlanes);
  WriteGroups(this->Symbols, vertices, coordinates, numbers, this->Shape.counts.own);
  WriteGhosts(this->Symbols, vertices, this->Content.keys, numbers);
}

// Writes each number as the difference from the previous one.
void PieceWriter::WriteArray(std::size_t context, const std::vector<std::uint64_t>& values)
{
  std::uint64_t last = 0;
  for (const std::uint64_t value : values)
  {
    this->Symbols.Signed(context, static_cast<std::int64_t>(value - last));
    last = value;
  }
}

// Original: nothing; the keys are those of the partition from 0 on. Levels coarser than S: the
// first key; the others are consecutive. Other levels: for each vertex the first vertex of its
// cluster's interval.
void PieceWriter::WriteOwnKeys()
{
  const std::size_t own = this->Shape.counts.own;
  if (this->Shape.IsOriginal())
  {
    return;
  }
  if (this->Shape.IsBelowStitch())
  {
    this->Symbols.Number(contexts::single, own == 0 ? 0 : this->Content.keys[0]);
    return;
  }
  // A key holds a partition and an index. Keys ascend, so each is stored as its difference from the
  // lowest key that can follow the one before.
  std::uint64_t partition = 0, index = 0; // the lowest key that the next vertex can have
  for (std::size_t v = 0; v < own; ++v)
  {
    const VertexKey key = this->Content.keys[v];
    const std::uint64_t further = PartitionOfKey(key) - partition;
    this->Symbols.Number(contexts::ownPartition, further);
    this->Symbols.Number(contexts::ownIndex, IndexOfKey(key) - (further > 0 ? 0 : index));
    partition = PartitionOfKey(key);
    index = std::uint64_t{ IndexOfKey(key) } + 1;
  }
}

// Writes ranks of parents level by level, fine to coarse: first the parent of each vertex, then the
// parent of each cluster that is an ancestor.
void PieceWriter::WriteAncestors()
{
  const AncestorShape shape = this->Shape.Ancestors();
  AncestorTable table(
    shape.vertices, shape.ofAll ? std::span(this->Content.triangles) : std::span<const Triangle>());
  std::vector<std::uint32_t> parents;
  for (std::size_t level = shape.levels; level-- > 0;)
  {
    parents.resize(table.Count());
    for (std::size_t v = 0; v < shape.vertices; ++v)
    {
      parents[table.EntryOfVertex(v)] = this->Content.ancestors[v * shape.levels + level];
    }
    SiblingGroups groups(parents.size());
    this->WriteParents(level + 1 == shape.levels, table, parents, groups);
    table.Rise(parents, groups);
  }
}

// ofVertices: whether entries are vertices, not clusters.
void PieceWriter::WriteParents(bool ofVertices, const AncestorTable& table,
  const std::vector<std::uint32_t>& parents, SiblingGroups& groups)
{
  const std::size_t siblings = contexts::siblings + (ofVertices ? 0 : 4);
  RecentRanks recent;
  for (std::size_t entry = 0; entry < parents.size(); ++entry)
  {
    const SiblingGroups::Choices around = groups.Around(table.EarlierNeighboursOf(entry));
    const auto* begin = around.groups.data();
    const auto* found = std::find_if(begin, begin + around.count,
      [&](std::uint32_t group) { return parents[group] == parents[entry]; });
    const bool joins = found != begin + around.count;
    if (around.count > 0)
    {
      this->Symbols.Choice(
        siblings + around.Context(), joins ? static_cast<unsigned>(found - begin) + 1 : 0);
    }
    if (joins)
    {
      groups.Join(entry, *found);
      continue;
    }
    groups.Start(entry);
    const std::uint64_t rank = parents[entry];
    const unsigned symbol = recent.SymbolOf(rank);
    this->Symbols.Choice(contexts::parentOf + (ofVertices ? 0 : 1), symbol);
    if (symbol == RecentRanks::other)
    {
      this->Symbols.Signed(contexts::ancestor, static_cast<std::int64_t>(rank - recent.Newest()));
    }
    recent.Use(symbol, rank);
  }
}

void PieceWriter::WriteChildNodes()
{
  if (this->Shape.HasChildNodes())
  {
    const auto& begin = this->Content.childBegin;
    const auto& nodes = this->Content.childNodes;
    this->WriteArray(contexts::childEnd, { begin.begin() + 1, begin.end() });
    this->WriteArray(contexts::childNode, { nodes.begin(), nodes.end() });
  }
}

void PieceWriter::WriteAttribute(std::size_t number)
{
  const Attribute& attribute = this->Content.attributes[number];
  const bool ofVertices = attribute.association == AttributeAssociation::Point;
  const std::size_t tuples = ofVertices ? this->Shape.Vertices() : this->Shape.counts.triangles;
  const std::size_t size = SizeOf(attribute.type), tupleSize = attribute.TupleSize();
  const ComponentOrder order(attribute.type);
  AttributePredictor predictor(
    attribute, tuples, ofVertices ? this->Walk.Vertices() : std::span<const WalkVertex>());
  const bool isCoarse = this->Shape.coarse[number] != 0;
  std::uint64_t ofRed = 0;
  for (std::size_t t = 0; t < tuples; ++t)
  {
    const std::size_t tuple = ofVertices ? this->Walk.Numbers()[t] : t;
    const std::uint8_t* from = attribute.values.data() + tuple * tupleSize;
    for (std::size_t c = 0; c < attribute.components; ++c)
    {
      std::uint64_t bits = 0;
      for (std::size_t i = 0; i < size; ++i)
      {
        bits |= std::uint64_t{ *from++ } << (8 * i);
      }
      const std::uint64_t value = isCoarse ? CoarseOf(bits) : order.Ordered(bits);
      const std::int64_t difference = predictor.Difference(value, predictor.Predict(t, c, ofRed));
      this->Symbols.Signed(contexts::attribute + number, difference);
      ofRed = isCoarse && c == 0 ? static_cast<std::uint64_t>(difference) : ofRed;
      predictor.Set(t, c, value);
    }
  }
}

}
