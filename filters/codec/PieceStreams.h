// A piece's content as symbols and back, in the order of the format: doc/formats.md, "A piece". One
// template for both directions: a SymbolWriter is told what a piece holds, a SymbolReader fills it.
#pragma once

#include "filters/codec/PackedTriangles.h"
#include "filters/codec/PieceCodec.h"
#include "filters/codec/PieceNumbering.h"
#include "filters/codec/PositionStream.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/SortTriangles.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <memory>
#include <type_traits>
#include <vector>

namespace kdstream
{

// What the counts in a blob's head, and its id, say about the arrays that follow.
struct PieceShape
{
  PieceId id;
  TreeDepths depths;
  std::size_t own = 0, ghosts = 0, triangles = 0, steps = 0, reach = 0;

  std::size_t Vertices() const { return this->own + this->ghosts; }
  bool IsOriginal() const { return this->id.resolution.IsOriginal(); }
  bool BelowStitch() const { return this->id.resolution < Resolution::Level(this->depths.stitch); }
  bool IsStitch() const { return this->id.resolution == Resolution::Level(this->depths.stitch); }
  // Vertices that carry the ranks of their ancestors.
  std::size_t Carriers() const
  {
    return this->BelowStitch() ? 0 : (this->IsStitch() ? this->Vertices() : this->ghosts);
  }
};

// A position on the grid, or exact; the last argument says which.
inline GridPredictor::Point PointOf(
  const Vec3& position, const CoordinateGrid& grid, const GridPredictor::Point&)
{
  const auto [x, y, z] = grid.Quantize(position);
  return GridPredictor::Point{ x, y, z, 0 };
}
inline ExactPredictor::Point PointOf(
  const Vec3& position, const CoordinateGrid& grid, const ExactPredictor::Point&)
{
  return grid.Snap(position);
}

// Ascends with (x, y, z), as far as 64 bits tell places apart.
inline std::uint64_t PlaceOf(const GridPredictor::Point& point)
{
  return std::uint64_t{ point[0] } << 40 | std::uint64_t{ point[1] } << 16 | point[2] >> 8;
}
inline std::uint64_t PlaceOf(const ExactPredictor::Point& point)
{
  return OrderedBits(point[0] + 0.0); // -0.0 is 0.0
}

// The bits of a component as an unsigned integer in the order of its values, and back: the sign is
// turned over, or all bits of a negative float (for `back`, of what was one).
inline std::uint64_t InOrder(std::uint64_t bits, AttributeType type, bool back)
{
  const std::uint64_t sign = std::uint64_t{ 1 } << (8 * SizeOf(type) - 1);
  const bool isUnsigned = type <= AttributeType::UInt64 && static_cast<unsigned>(type) % 2 == 1;
  const bool isNegativeFloat = type >= AttributeType::Float32 && ((bits & sign) == 0) == back;
  return isUnsigned ? bits : bits ^ (isNegativeFloat ? sign | (sign - 1) : sign);
}

template <class Coder>
class PieceStreams
{
public:
  using PieceType = std::conditional_t<Coder::reading, Piece, const Piece>;

  // Reading: `piece` has its id and primitive, and its attributes but for their values.
  PieceStreams(Coder& coder, PieceType& piece, const PieceShape& shape, const CoordinateGrid& grid)
    : Coding(coder)
    , Content(piece)
    , Shape(shape)
    , Grid(grid)
    , Walk(coder, shape.own, shape.ghosts, shape.triangles, shape.steps)
  {
  }

  // Null, or what is wrong with what was read.
  const char* Code()
  {
    bool walked = true;
    if constexpr (Coder::reading)
    {
      walked = this->Walk.CodeSteps(this->Coding) && this->Walk.Run();
    }
    else
    {
      this->Walk.SetInput(this->Content.triangles, this->Shape.own, this->Shape.ghosts);
      (void)(this->Walk.Run() && this->Walk.CodeSteps(this->Coding));
    }
    if (!walked)
    {
      return "triangles out of range";
    }
    this->AddIsolated();
    const bool good = this->Grid.Lossless() ? this->template CodeVertices<ExactPredictor>()
                                            : this->template CodeVertices<GridPredictor>();
    if (!good)
    {
      return "vertices out of range";
    }
    if constexpr (Coder::reading)
    {
      this->PlaceTriangles();
    }
    if (!this->CodeOwnKeys())
    {
      return "keys out of range";
    }
    if (!this->CodeDeviations() || !this->CodeAncestors() || !this->CodeReach())
    {
      return "keys out of range";
    }
    for (std::size_t i = 0; i < this->Content.attributes.size(); ++i)
    {
      this->CodeAttribute(i);
    }
    return nullptr;
  }

  // Writing, after Code.
  std::size_t StepCount() const { return this->Walk.Steps.size(); }

private:
  bool CodeArray(std::size_t context, std::vector<std::uint64_t>& values, std::uint64_t most);
  void AddIsolated();
  template <class Predictor>
  bool CodeVertices();
  template <class Predictor>
  bool ReadPoints(typename Predictor::Point* points);
  template <class Point>
  void PlaceVertices(const Point* points);
  void PlaceTriangles();
  bool CodeOwnKeys();
  bool CodeDeviations();
  bool CodeAncestors();
  bool CodeReach();
  void CodeAttribute(std::size_t number);
  std::uint64_t CodeComponent(
    std::size_t number, std::size_t tuple, std::size_t component, std::uint64_t foretold);

  Coder& Coding;
  PieceType& Content;
  const PieceShape& Shape;
  const CoordinateGrid& Grid;
  TriangleWalk<Coder> Walk;
  NumberedVertices Numbered;
};

// Vertices that no triangle touches come behind the others: own ones by number, then ghosts by key.
template <class Coder>
void PieceStreams<Coder>::AddIsolated()
{
  auto& vertices = this->Walk.Vertices;
  for (std::uint32_t v = this->Walk.VertexCount; v < vertices.size(); ++v)
  {
    const std::uint32_t before = v == 0 ? 0 : v - 1;
    const bool own = v - this->Walk.VertexCount < this->Walk.OwnLeft;
    vertices[v].Start({ before, before, before }, own, false);
  }
  for (VertexId v = 0; !Coder::reading && v < vertices.size(); ++v)
  {
    if (!this->Walk.Has(v))
    {
      this->Walk.Input.push_back(v);
    }
  }
}

// Positions, and which numbers the vertices have.
template <class Coder>
template <class Predictor>
bool PieceStreams<Coder>::CodeVertices()
{
  const std::size_t count = this->Walk.Vertices.size();
  this->Numbered.vertices = this->Walk.Vertices;
  this->Numbered.own = this->Shape.own;
  const std::unique_ptr<typename Predictor::Point[]> points(new typename Predictor::Point[count]);
  if constexpr (Coder::reading)
  {
    this->Numbered.numbers.resize(count);
    this->Content.keys.resize(count);
    if (!this->template ReadPoints<Predictor>(points.get()) ||
        !CodeGhosts(this->Coding, this->Numbered, std::span(this->Content.keys)))
    {
      return false;
    }
    this->PlaceVertices(points.get());
    return true;
  }
  else
  {
    this->Numbered.positions.resize(count);
    for (std::size_t v = 0; v < count; ++v)
    {
      const Vec3& position = this->Content.positions[this->Walk.Input[v]];
      const auto& point = points[v] = PointOf(position, this->Grid, points[v]);
      this->Numbered.positions[v] = { double(point[0]), double(point[1]), double(point[2]) };
    }
    this->Numbered.numbers = this->Walk.Input;
    WritePositions<Predictor>(this->Coding, this->Grid, this->Numbered.vertices, points.get());
    WriteGroups(this->Coding, this->Numbered);
    return CodeGhosts(this->Coding, this->Numbered, std::span(this->Content.keys));
  }
}

// Reading: where the vertices are, and the numbers of own ones. A vertex is foretold and tells its
// group in one go: either waits for what came before, and not for the other.
template <class Coder>
template <class Predictor>
bool PieceStreams<Coder>::ReadPoints(typename Predictor::Point* points)
{
  PositionMode mode;
  if (!CodePositionMode(this->Coding, mode))
  {
    return false;
  }
  const auto vertices = this->Numbered.vertices;
  using Differences = typename Predictor::Differences;
  const std::unique_ptr<Differences[]> differences(new Differences[vertices.size()]);
  if (!ReadDifferences<Predictor>(this->Coding, mode, vertices, differences.get()))
  {
    return false;
  }
  const Predictor predictor(this->Grid, mode.reach);
  GroupCoder<Coder> groups(this->Coding, this->Numbered);
  typename Predictor::Point outside{};
  bool good = true;
  for (std::size_t v = 0; v < vertices.size() && good; ++v)
  {
    points[v] = predictor.At(Foretold(predictor, vertices, v, points), differences[v]);
    predictor.Check(points[v], outside);
    good = vertices[v].own == 0 || groups.Code(v);
  }
  this->Coding.Continue(groups.Cursor);
  if (!good || predictor.IsAny(outside))
  {
    return false;
  }
  NumberByGroup(
    this->Numbered, groups.All(), [=](std::uint32_t v) { return PlaceOf(points[v]); },
    [=](std::uint32_t v, std::uint32_t w)
    {
      const auto at = [=](std::uint32_t u) {
        return std::array{ points[u][0], points[u][1], points[u][2] };
      };
      return at(v) != at(w) ? at(v) < at(w) : v < w;
    });
  return true;
}

// Reading: positions in the order of their numbers.
template <class Coder>
template <class Point>
void PieceStreams<Coder>::PlaceVertices(const Point* points)
{
  if constexpr (Coder::reading)
  {
    const std::size_t count = this->Numbered.vertices.size();
    this->Content.positions.resize(count);
    for (std::size_t v = 0; v < count; ++v)
    {
      Vec3& to = this->Content.positions[this->Numbered.numbers[v]];
      for (std::size_t k = 0; k < 3; ++k)
      {
        to[k] = std::is_same_v<Point, Vec3> ? points[v][k]
                                            : this->Grid.origin[k] + points[v][k] * this->Grid.step;
      }
    }
  }
}

// The walk's triangles in the piece's numbers, sorted.
template <class Coder>
void PieceStreams<Coder>::PlaceTriangles()
{
  if constexpr (Coder::reading)
  {
    auto& triangles = this->Content.triangles;
    const VertexId* numbers = this->Numbered.numbers.data();
    triangles.resize(this->Shape.triangles);
    if (this->Shape.Vertices() <= std::size_t{ 1 } << PackedTriangles::bits)
    {
      PackedTriangles packed(triangles.size(), this->Shape.Vertices());
      for (std::size_t t = 0; t < triangles.size(); ++t)
      {
        const auto& [a, b, c] = this->Walk.CornersOf(t);
        packed.Add(numbers[a], numbers[b], numbers[c]);
      }
      packed.Sort(triangles);
      return;
    }
    for (std::size_t t = 0; t < triangles.size(); ++t)
    {
      const auto& [a, b, c] = this->Walk.CornersOf(t);
      triangles[t] = RotateLowestFirst({ numbers[a], numbers[b], numbers[c] });
    }
    std::vector<Triangle> other;
    SortByMerging(triangles, other, std::less<>());
  }
}

// Numbers of 0 … most, each as the difference to the one before.
template <class Coder>
bool PieceStreams<Coder>::CodeArray(
  std::size_t context, std::vector<std::uint64_t>& values, std::uint64_t most)
{
  std::uint64_t last = 0;
  for (std::uint64_t& value : values)
  {
    last += static_cast<std::uint64_t>(
      this->Coding.Signed(context, static_cast<std::int64_t>(value - last)));
    if (last > most)
    {
      return false;
    }
    value = last;
  }
  return true;
}

// Of the original implied; below S the first, the others follow; else the first vertex of each
// cluster's interval.
template <class Coder>
bool PieceStreams<Coder>::CodeOwnKeys()
{
  const std::size_t own = this->Shape.own;
  if (this->Shape.BelowStitch() || this->Shape.IsOriginal())
  {
    VertexKey first = 0;
    if constexpr (!Coder::reading)
    {
      first = own == 0 ? 0 : this->Content.keys[0];
    }
    if (this->Shape.IsOriginal())
    {
      first = MakeKey(this->Shape.id.node - (NodeId{ 1 } << this->Shape.depths.partition), 0);
    }
    else
    {
      first = this->Coding.Number(contexts::single, first);
    }
    for (std::size_t v = 0; Coder::reading && v < own; ++v)
    {
      if constexpr (Coder::reading)
      {
        this->Content.keys[v] = first + v;
      }
    }
    return first >> 32 == 0 || this->Shape.IsOriginal();
  }
  std::vector<std::uint64_t> partitions(own), indices(own);
  for (std::size_t v = 0; !Coder::reading && v < own; ++v)
  {
    partitions[v] = PartitionOfKey(this->Content.keys[v]);
    indices[v] = IndexOfKey(this->Content.keys[v]);
  }
  if (!this->CodeArray(contexts::ownPartition, partitions, noVertex) ||
      !this->CodeArray(contexts::ownIndex, indices, noVertex))
  {
    return false;
  }
  for (std::size_t v = 0; Coder::reading && v < own; ++v)
  {
    if constexpr (Coder::reading)
    {
      this->Content.keys[v] =
        MakeKey(static_cast<std::uint32_t>(partitions[v]), static_cast<std::uint32_t>(indices[v]));
    }
  }
  return true;
}

// Ordered bits of floats without the low bits that are 0 in all.
template <class Coder>
bool PieceStreams<Coder>::CodeDeviations()
{
  if (this->Shape.IsOriginal())
  {
    return true;
  }
  std::uint64_t shift = 31;
  if constexpr (Coder::reading)
  {
    this->Content.deviations.resize(this->Shape.own);
  }
  for (const float deviation : this->Content.deviations)
  {
    shift = std::min<std::uint64_t>(
      shift, static_cast<unsigned>(std::countr_zero(OrderedBits(deviation) | 1U << 31)));
  }
  shift = this->Coding.Number(contexts::single, shift);
  if (shift > 31)
  {
    return false;
  }
  std::vector<std::uint64_t> bits(this->Shape.own);
  for (std::size_t v = 0; !Coder::reading && v < bits.size(); ++v)
  {
    bits[v] = OrderedBits(this->Content.deviations[v]) >> shift;
  }
  // Up to the greatest float.
  if (!this->CodeArray(contexts::deviation, bits, 0xFF7FFFFF >> shift))
  {
    return false;
  }
  for (std::size_t v = 0; Coder::reading && v < bits.size(); ++v)
  {
    if constexpr (Coder::reading)
    {
      this->Content.deviations[v] =
        FloatOfOrderedBits(static_cast<std::uint32_t>(bits[v] << shift));
      if (!(this->Content.deviations[v] >= 0))
      {
        return false;
      }
    }
  }
  return true;
}

// Rows of S ranks, coarse to fine: how many of the finest differ from the row before, and by what.
template <class Coder>
bool PieceStreams<Coder>::CodeAncestors()
{
  const std::size_t stitch = this->Shape.depths.stitch, rows = this->Shape.Carriers();
  if constexpr (Coder::reading)
  {
    this->Content.ancestors.resize(rows * stitch);
  }
  std::vector<std::uint64_t> before(stitch);
  for (std::size_t row = 0; stitch > 0 && row < rows; ++row)
  {
    auto* ranks = this->Content.ancestors.data() + row * stitch;
    std::size_t differ = stitch;
    while (!Coder::reading && differ > 0 && ranks[stitch - differ] == before[stitch - differ])
    {
      --differ;
    }
    const std::uint64_t coded = this->Coding.Number(contexts::ancestorDepth, differ);
    if (coded > stitch)
    {
      return false;
    }
    differ = static_cast<std::size_t>(coded);
    for (std::size_t d = stitch - differ; d < stitch; ++d)
    {
      before[d] += static_cast<std::uint64_t>(
        this->Coding.Signed(contexts::ancestor, static_cast<std::int64_t>(ranks[d] - before[d])));
      if (before[d] >= noVertex)
      {
        return false;
      }
    }
    for (std::size_t d = 0; Coder::reading && d < stitch; ++d)
    {
      if constexpr (Coder::reading)
      {
        ranks[d] = static_cast<std::uint32_t>(before[d]);
      }
    }
  }
  return true;
}

template <class Coder>
bool PieceStreams<Coder>::CodeReach()
{
  if (!this->Shape.BelowStitch())
  {
    return true;
  }
  std::vector<std::uint64_t> ends(this->Shape.own), nodes(this->Shape.reach);
  if constexpr (!Coder::reading)
  {
    ends.assign(this->Content.reachBegin.begin() + 1, this->Content.reachBegin.end());
    nodes.assign(this->Content.reachNodes.begin(), this->Content.reachNodes.end());
  }
  if (!this->CodeArray(contexts::reachEnd, ends, noVertex) ||
      !this->CodeArray(contexts::reachNode, nodes, noVertex))
  {
    return false;
  }
  if constexpr (Coder::reading)
  {
    this->Content.reachBegin.resize(ends.size() + 1);
    this->Content.reachNodes.resize(nodes.size());
    for (std::size_t v = 0; v < ends.size(); ++v)
    {
      this->Content.reachBegin[v + 1] = static_cast<std::uint32_t>(ends[v]);
    }
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
      this->Content.reachNodes[i] = static_cast<NodeId>(nodes[i]);
    }
  }
  return true;
}

template <class Coder>
std::uint64_t PieceStreams<Coder>::CodeComponent(
  std::size_t number, std::size_t tuple, std::size_t component, std::uint64_t foretold)
{
  auto& attribute = this->Content.attributes[number];
  const std::size_t size = SizeOf(attribute.type);
  auto* bytes = attribute.values.data() + tuple * attribute.TupleSize() + component * size;
  const unsigned unused = static_cast<unsigned>(64 - 8 * size);
  std::uint64_t value = 0;
  for (std::size_t i = 0; !Coder::reading && i < size; ++i)
  {
    value |= std::uint64_t{ bytes[i] } << (8 * i);
  }
  value = Coder::reading ? 0 : InOrder(value, attribute.type, false);
  // The difference within the type's width, sign and all.
  const auto difference = static_cast<std::int64_t>((value - foretold) << unused) >> unused;
  value = foretold +
          static_cast<std::uint64_t>(this->Coding.Signed(contexts::attribute + number, difference));
  value = value << unused >> unused;
  if constexpr (Coder::reading)
  {
    const std::uint64_t stored = InOrder(value, attribute.type, true);
    for (std::size_t i = 0; i < size; ++i)
    {
      bytes[i] = static_cast<std::uint8_t>(stored >> (8 * i));
    }
  }
  return value;
}

// Vertices in the order of the walk: difference to the mean at the gate's two. Triangles in the
// order of the piece: to the triangle before.
template <class Coder>
void PieceStreams<Coder>::CodeAttribute(std::size_t number)
{
  auto& attribute = this->Content.attributes[number];
  const bool ofVertices = attribute.association == AttributeAssociation::Point;
  const std::size_t tuples = ofVertices ? this->Shape.Vertices() : this->Shape.triangles;
  const std::size_t components = attribute.components;
  if constexpr (Coder::reading)
  {
    attribute.values.resize(tuples * attribute.TupleSize());
  }
  std::vector<std::uint64_t> known(tuples * components);
  for (std::size_t t = 0; t < tuples; ++t)
  {
    std::size_t a = std::max<std::size_t>(t, 1) - 1, b = a;
    if (ofVertices)
    {
      a = this->Walk.Vertices[t].gate[0];
      b = this->Walk.Vertices[t].gate[1];
    }
    for (std::size_t c = 0; c < components; ++c)
    {
      const std::uint64_t atA = known[a * components + c], atB = known[b * components + c];
      known[t * components + c] = this->CodeComponent(
        number, ofVertices ? this->Numbered.numbers[t] : t, c, (atA & atB) + ((atA ^ atB) >> 1));
    }
  }
}

}
