// The plain piece codec: see PieceCodec.h and doc/formats.md. Encoder and decoder stand side by
// side, array by array, in the order of the bytes.
#include "filters/codec/PieceCodec.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/Seal.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::string_view magic = "KDP";

// What the counts in a blob's head, and its id, say about the arrays that follow.
struct Shape
{
  PieceId id;
  TreeDepths depths;
  std::size_t own = 0, ghosts = 0, triangles = 0;

  std::size_t Vertices() const { return this->own + this->ghosts; }
  bool IsOriginal() const { return this->id.resolution.IsOriginal(); }
  bool BelowStitch() const { return this->id.resolution < Resolution::Level(this->depths.stitch); }
  bool IsStitch() const { return this->id.resolution == Resolution::Level(this->depths.stitch); }
  std::size_t Carriers() const
  {
    return this->BelowStitch() ? 0 : (this->IsStitch() ? this->Vertices() : this->ghosts);
  }
};

template <class Value>
std::vector<std::uint64_t> Collect(std::size_t count, const Value& value)
{
  std::vector<std::uint64_t> values(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    values[i] = value(i);
  }
  return values;
}

// ---- keys
// ----------------------------------------------------------------------------------------------------
// Own keys: implied for the original; the first rank below S; else partitions and indices. Ghost
// keys: ranks below S, else partitions and indices.

void WriteKeyPairs(ByteWriter& writer, std::span<const VertexKey> keys)
{
  writer.Stream(Collect(keys.size(), [&](std::size_t i) { return PartitionOfKey(keys[i]); }));
  writer.Stream(Collect(keys.size(), [&](std::size_t i) { return IndexOfKey(keys[i]); }), 1);
}

void WriteKeys(ByteWriter& writer, const Piece& piece, const Shape& shape)
{
  const std::span<const VertexKey> keys = piece.keys;
  const auto own = keys.first(piece.ownVertices), ghosts = keys.subspan(piece.ownVertices);
  if (shape.BelowStitch())
  {
    writer.Varint(own.empty() ? 0 : own[0]);
    writer.Stream(ghosts);
    return;
  }
  if (!shape.IsOriginal())
  {
    WriteKeyPairs(writer, own);
  }
  WriteKeyPairs(writer, ghosts);
}

void ReadKeyPairs(ByteReader& reader, std::size_t count, std::vector<VertexKey>& keys)
{
  const auto partitions = reader.Stream(count);
  const auto indices = reader.Stream(count, 1);
  for (std::size_t i = 0; !reader.Failed() && i < count; ++i)
  {
    if ((partitions[i] | indices[i]) >> 32 != 0)
    {
      reader.Fail("key out of range");
      return;
    }
    keys.push_back(
      MakeKey(static_cast<std::uint32_t>(partitions[i]), static_cast<std::uint32_t>(indices[i])));
  }
}

void ReadKeys(ByteReader& reader, Piece& piece, const Shape& shape)
{
  if (shape.BelowStitch())
  {
    const std::uint64_t firstRank = reader.Varint(noVertex - 1);
    const auto ghosts = reader.Stream(shape.ghosts);
    for (std::uint64_t i = 0; !reader.Failed() && i < shape.own; ++i)
    {
      piece.keys.push_back(firstRank + i);
    }
    piece.keys.insert(piece.keys.end(), ghosts.begin(), ghosts.end());
    return;
  }
  if (shape.IsOriginal())
  {
    const auto partition =
      static_cast<std::uint32_t>(shape.id.node - (NodeId{ 1 } << shape.depths.partition));
    for (std::uint64_t i = 0; i < shape.own; ++i)
    {
      piece.keys.push_back(MakeKey(partition, static_cast<std::uint32_t>(i)));
    }
  }
  else
  {
    ReadKeyPairs(reader, shape.own, piece.keys);
  }
  ReadKeyPairs(reader, shape.ghosts, piece.keys);
}

// ---- positions: one stream an axis, grid coordinates or ordered bits
// -----------------------------------------

void WritePositions(ByteWriter& writer, const Piece& piece, const CoordinateGrid& grid)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    writer.Stream(Collect(piece.positions.size(),
                    [&](std::size_t i) -> std::uint64_t
                    {
                      const Vec3& p = piece.positions[i];
                      if (!grid.Lossless())
                      {
                        return grid.Quantize(p)[axis];
                      }
                      return grid.scalarType == ScalarType::Float32
                               ? OrderedBits(static_cast<float>(p[axis]))
                               : OrderedBits(p[axis]);
                    }),
      1);
  }
}

void ReadPositions(ByteReader& reader, Piece& piece, const Shape& shape, const CoordinateGrid& grid)
{
  const std::uint64_t most =
    grid.Lossless() ? (grid.scalarType == ScalarType::Float32 ? 0xFFFFFFFFU : ~std::uint64_t{ 0 })
                    : (std::uint64_t{ 1 } << grid.bits) - 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const auto values = reader.Stream(shape.Vertices(), 1);
    if (reader.Failed())
    {
      return;
    }
    piece.positions.resize(shape.Vertices());
    for (std::size_t i = 0; i < values.size(); ++i)
    {
      if (values[i] > most)
      {
        reader.Fail("coordinate out of range");
        return;
      }
      double& value = piece.positions[i][axis];
      if (!grid.Lossless())
      {
        value = grid.origin[axis] + static_cast<std::uint32_t>(values[i]) * grid.step;
      }
      else
      {
        value = grid.scalarType == ScalarType::Float32
                  ? double(FloatOfOrderedBits(static_cast<std::uint32_t>(values[i])))
                  : DoubleOfOrderedBits(values[i]);
      }
    }
  }
}

// ---- what only levels have: deviations, ancestors, reach
// -----------------------------------------------------

void WriteLevel(ByteWriter& writer, const Piece& piece, const Shape& shape)
{
  writer.Stream(Collect(
    piece.deviations.size(), [&](std::size_t i) { return OrderedBits(piece.deviations[i]); }));
  const std::size_t stitch = shape.depths.stitch;
  for (std::size_t d = 0; d < (shape.BelowStitch() ? 0 : stitch); ++d)
  {
    writer.Stream(
      Collect(shape.Carriers(), [&](std::size_t i) { return piece.ancestors[i * stitch + d]; }));
  }
  if (shape.BelowStitch())
  {
    writer.Varint(piece.reachNodes.size());
    writer.Stream(Collect(piece.ownVertices,
      [&](std::size_t i) { return piece.reachBegin[i + 1] - piece.reachBegin[i]; }));
    writer.Stream(
      Collect(piece.reachNodes.size(), [&](std::size_t i) { return piece.reachNodes[i]; }), 1);
  }
}

void ReadReach(ByteReader& reader, Piece& piece, const Shape& shape)
{
  const std::size_t total = reader.Count(reader.Remaining());
  const auto counts = reader.Stream(shape.own);
  const auto nodes = reader.Stream(total, 1);
  std::uint64_t sum = 0;
  piece.reachBegin.push_back(0);
  for (const std::uint64_t count : counts)
  {
    sum += std::min<std::uint64_t>(count, noVertex);
    if (sum > total)
    {
      reader.Fail("reach out of range");
      return;
    }
    piece.reachBegin.push_back(static_cast<std::uint32_t>(sum));
  }
  for (const std::uint64_t node : nodes)
  {
    if (node > noVertex)
    {
      reader.Fail("node out of range");
      return;
    }
    piece.reachNodes.push_back(static_cast<NodeId>(node));
  }
}

void ReadLevel(ByteReader& reader, Piece& piece, const Shape& shape)
{
  for (const std::uint64_t bits : reader.Stream(shape.IsOriginal() ? 0 : shape.own))
  {
    const float deviation = FloatOfOrderedBits(static_cast<std::uint32_t>(bits));
    if (bits >> 32 != 0 || !(deviation >= 0) || deviation > std::numeric_limits<float>::max())
    {
      reader.Fail("deviation out of range");
      return;
    }
    piece.deviations.push_back(deviation);
  }
  const std::size_t stitch = shape.depths.stitch;
  for (std::size_t d = 0; d < (shape.BelowStitch() ? 0 : stitch); ++d)
  {
    const auto ranks = reader.Stream(shape.Carriers());
    if (reader.Failed())
    {
      return;
    }
    piece.ancestors.resize(shape.Carriers() * stitch);
    for (std::size_t i = 0; i < ranks.size(); ++i)
    {
      if (ranks[i] >= noVertex)
      {
        reader.Fail("ancestor out of range");
        return;
      }
      piece.ancestors[i * stitch + d] = static_cast<std::uint32_t>(ranks[i]);
    }
  }
  if (shape.BelowStitch())
  {
    ReadReach(reader, piece, shape);
  }
}

// ---- triangles: the first index, and the two others relative to it
// -------------------------------------------

void WriteTriangles(ByteWriter& writer, const Piece& piece)
{
  const std::size_t count = piece.triangles.size();
  writer.Stream(Collect(count, [&](std::size_t i) { return piece.triangles[i][0]; }), 1);
  for (std::size_t k = 1; k < 3; ++k)
  {
    writer.Stream(Collect(count, [&](std::size_t i) { return piece.triangles[i][k]; }));
  }
}

void ReadTriangles(ByteReader& reader, Piece& piece, const Shape& shape)
{
  const auto a = reader.Stream(shape.triangles, 1);
  const auto b = reader.Stream(shape.triangles);
  const auto c = reader.Stream(shape.triangles);
  if (reader.Failed())
  {
    return;
  }
  piece.triangles.reserve(shape.triangles);
  for (std::size_t i = 0; i < shape.triangles; ++i)
  {
    if (std::max({ a[i], b[i], c[i] }) >= shape.Vertices())
    {
      reader.Fail("triangle index out of range");
      return;
    }
    piece.triangles.push_back(
      { static_cast<VertexId>(a[i]), static_cast<VertexId>(b[i]), static_cast<VertexId>(c[i]) });
  }
}

// ---- attributes: a table of contents entry and the raw values of each
// ----------------------------------------

void WriteAttributes(ByteWriter& writer, const Piece& piece)
{
  writer.Varint(piece.attributes.size());
  for (const Attribute& attribute : piece.attributes)
  {
    const auto name = std::span(
      reinterpret_cast<const std::uint8_t*>(attribute.name.data()), attribute.name.size());
    writer.Varint(name.size());
    writer.Raw(name);
    writer.Byte(static_cast<std::uint8_t>(attribute.type));
    writer.Byte(static_cast<std::uint8_t>(attribute.association));
    writer.Byte(attribute.components);
    writer.Varint(attribute.values.size());
    writer.Raw(attribute.values);
  }
}

void ReadAttributes(ByteReader& reader, Piece& piece)
{
  const std::uint64_t count = reader.Varint(mostAttributes);
  for (std::uint64_t i = 0; !reader.Failed() && i < count; ++i)
  {
    Attribute attribute;
    const auto name = reader.Raw(reader.Count(longestAttributeName));
    attribute.name.assign(name.begin(), name.end());
    const std::uint8_t type = reader.Byte(), association = reader.Byte();
    attribute.components = reader.Byte();
    if (type > static_cast<std::uint8_t>(AttributeType::Float64) || association > 1)
    {
      reader.Fail("unknown attribute type");
      return;
    }
    attribute.type = static_cast<AttributeType>(type);
    attribute.association = static_cast<AttributeAssociation>(association);
    const auto values = reader.Raw(reader.Count(reader.Remaining()));
    attribute.values.assign(values.begin(), values.end());
    piece.attributes.push_back(std::move(attribute));
  }
}

Error Named(Error error, PieceId id)
{
  const std::string resolution =
    id.resolution.IsOriginal() ? "the original" : "level " + std::to_string(id.resolution.Depth());
  error.message = "piece " + std::to_string(id.node) + " of " + resolution + ": " + error.message;
  return error;
}

}

std::vector<std::uint8_t> EncodePiece(const Piece& piece, const CodecContext& context)
{
  const Shape shape{ piece.id, context.depths, piece.ownVertices, piece.GhostCount(),
    piece.triangles.size() };
  ByteWriter writer;
  WriteBlobHead(writer, magic);
  writer.Byte(static_cast<std::uint8_t>(piece.primitive));
  writer.Varint(shape.own);
  writer.Varint(shape.ghosts);
  writer.Varint(shape.triangles);
  WritePositions(writer, piece, context.grid);
  WriteKeys(writer, piece, shape);
  WriteLevel(writer, piece, shape);
  WriteTriangles(writer, piece);
  WriteAttributes(writer, piece);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  return blob;
}

Result<Piece> DecodePiece(
  std::span<const std::uint8_t> blob, PieceId expected, const CodecContext& context)
{
  const auto unsealed = UnsealBlob(blob, magic);
  if (!unsealed)
  {
    return Named(unsealed.GetError(), expected);
  }
  ByteReader reader(*unsealed);
  (void)reader.Raw(blobHeadSize);
  Piece piece;
  piece.id = expected;
  const std::uint8_t primitive = reader.Byte();
  if (primitive > static_cast<std::uint8_t>(PrimitiveType::Triangles))
  {
    reader.Fail("unknown primitive type");
  }
  piece.primitive = static_cast<PrimitiveType>(primitive);
  Shape shape{ expected, context.depths };
  shape.own = reader.Count(unsealed->size());
  shape.ghosts = reader.Count(unsealed->size());
  shape.triangles = reader.Count(unsealed->size());
  piece.ownVertices = static_cast<std::uint32_t>(shape.own);

  // After the first failure reads give nothing, so each step needs no check of its own.
  ReadPositions(reader, piece, shape, context.grid);
  if (!reader.Failed())
  {
    ReadKeys(reader, piece, shape);
  }
  if (!reader.Failed())
  {
    ReadLevel(reader, piece, shape);
  }
  if (!reader.Failed())
  {
    ReadTriangles(reader, piece, shape);
    ReadAttributes(reader, piece);
  }
  if (!reader.Failed() && reader.Remaining() > 0)
  {
    reader.Fail("bytes beyond the end");
  }
  if (reader.Failed())
  {
    return Named(reader.Why(), expected);
  }
  if (Status status = CheckPiece(piece, context.depths); !status)
  {
    return Named(status.GetError(), expected);
  }
  return piece;
}

}
