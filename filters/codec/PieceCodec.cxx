// SPDX-License-Identifier: BSD-3-Clause
// The piece codec: see PieceCodec.h and doc/formats.md. A blob has a head of bytes, then everything
// as symbols (PieceReader.h, PieceWriter.h).
#include "filters/codec/PieceCodec.h"

#include "filters/codec/ByteStream.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/PieceReader.h"
#include "filters/codec/PieceShape.h"
#include "filters/codec/PieceWriter.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"

#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::string_view pieceMagic = "KDP";

// A blob has at least one byte for each mostExpansion bytes of the decoded piece. This limits a
// reader's memory and time.
constexpr std::uint64_t mostExpansion = 128;

constexpr std::uint8_t coarseBit = 0x40; // in the byte of an attribute's type

// About how many bytes the piece takes in memory.
std::uint64_t DecodedBytes(const Piece& piece, const PieceShape& shape)
{
  const AncestorShape ancestors = shape.Ancestors();
  std::uint64_t bytes = 32 * std::uint64_t{ shape.Vertices() } +
                        12 * std::uint64_t{ shape.counts.triangles } +
                        4 * std::uint64_t{ shape.childNodes } +
                        4 * std::uint64_t{ ancestors.vertices } * ancestors.levels;
  for (const Attribute& attribute : piece.attributes)
  {
    bytes += std::uint64_t{ attribute.TupleSize() } *
             (attribute.association == AttributeAssociation::Point ? shape.Vertices()
                                                                   : shape.counts.triangles);
  }
  return bytes;
}

void WriteHead(ByteWriter& writer, const Piece& piece, const PieceShape& shape)
{
  WriteBlobHead(writer, pieceMagic);
  writer.Byte(static_cast<std::uint8_t>(piece.primitive));
  writer.Varint(shape.counts.own);
  writer.Varint(shape.counts.ghosts);
  writer.Varint(shape.counts.triangles);
  writer.Varint(shape.steps);
  if (shape.HasChildNodes())
  {
    writer.Varint(shape.childNodes);
  }
  writer.Varint(piece.attributes.size());
  for (std::size_t i = 0; i < piece.attributes.size(); ++i)
  {
    const Attribute& attribute = piece.attributes[i];
    const auto name = std::span(
      reinterpret_cast<const std::uint8_t*>(attribute.name.data()), attribute.name.size());
    writer.Varint(name.size());
    writer.Raw(name);
    writer.Byte(static_cast<std::uint8_t>(
      static_cast<std::uint8_t>(attribute.type) | (shape.coarse[i] != 0 ? coarseBit : 0)));
    writer.Byte(static_cast<std::uint8_t>(attribute.association));
    writer.Byte(attribute.components);
  }
}

void ReadAttributeHeads(ByteReader& reader, Piece& piece, PieceShape& shape)
{
  const std::uint64_t count = reader.Varint(mostAttributes);
  for (std::uint64_t i = 0; !reader.Failed() && i < count; ++i)
  {
    Attribute attribute;
    const auto name = reader.Raw(reader.Count(longestAttributeName));
    attribute.name.assign(reinterpret_cast<const char*>(name.data()), name.size());
    const std::uint8_t head = reader.Byte(), association = reader.Byte();
    const bool isCoarse = (head & coarseBit) != 0;
    const std::uint8_t type = isCoarse ? head ^ coarseBit : head;
    attribute.components = reader.Byte();
    if (type > static_cast<std::uint8_t>(AttributeType::Float64) || association > 1)
    {
      reader.Fail("unknown attribute type");
      return;
    }
    attribute.type = static_cast<AttributeType>(type);
    attribute.association = static_cast<AttributeAssociation>(association);
    if (isCoarse && RoleOf(attribute) != AttributeRole::Colors)
    {
      reader.Fail("a coarse attribute that is not of colours");
      return;
    }
    shape.coarse.push_back(isCoarse);
    piece.attributes.push_back(std::move(attribute));
  }
}

void ReadHead(ByteReader& reader, Piece& piece, PieceShape& shape)
{
  (void)reader.Raw(blobHeadSize);
  const std::uint8_t primitive = reader.Byte();
  if (primitive > static_cast<std::uint8_t>(PrimitiveType::Triangles))
  {
    reader.Fail("unknown primitive type");
  }
  piece.primitive = static_cast<PrimitiveType>(primitive);
  constexpr std::size_t most = noVertex / 64; // so that numbers of half-edges and sizes stay small
  shape.counts.own = reader.Count(most);
  shape.counts.ghosts = reader.Count(most);
  shape.counts.triangles = reader.Count(most);
  shape.steps = reader.Count(3 * shape.counts.triangles); // at most one step for each edge
  shape.childNodes = shape.HasChildNodes() ? reader.Count(most) : 0;
  piece.ownVertices = static_cast<std::uint32_t>(shape.counts.own);
  ReadAttributeHeads(reader, piece, shape);
  if (!reader.Failed() && DecodedBytes(piece, shape) / mostExpansion > reader.Remaining())
  {
    reader.Fail("counts are too large for the bytes");
  }
}

// Returns null, or what is wrong with the symbols.
const char* ReadSymbols(std::span<const std::uint8_t> bytes, Piece& piece, const PieceShape& shape,
  const CoordinateGrid& grid)
{
  SymbolReader symbols(bytes, { contexts::choices, contexts::attribute + piece.attributes.size() });
  if (!symbols.Failed())
  {
    const char* wrong = PieceReader(symbols, piece, shape, grid).Read();
    if (!symbols.Failed())
    {
      return wrong || symbols.AtEnd() ? wrong : "extra bytes at the end";
    }
  }
  return "truncated symbols";
}

Error Named(Error error, PieceId id)
{
  const std::string resolution =
    id.resolution.IsOriginal() ? "the original" : "level " + std::to_string(id.resolution.Depth());
  error.message = "piece " + std::to_string(id.node) + " of " + resolution + ": " + error.message;
  return error;
}

}

std::vector<std::uint8_t> EncodePiece(
  const Piece& piece, const CodecContext& context, EncodedBytes* spent)
{
  const WalkCounts counts{ piece.ownVertices, piece.GhostCount(), piece.triangles.size() };
  PieceShape shape{ piece.id, context.depths, counts, 0, piece.childNodes.size() };
  for (const Attribute& attribute : piece.attributes)
  {
    shape.coarse.push_back(context.coarseColors && !piece.id.resolution.IsOriginal() &&
                           RoleOf(attribute) == AttributeRole::Colors);
  }
  SymbolWriter symbols({ contexts::choices, contexts::attribute + piece.attributes.size() });
  const CoordinateGrid grid = context.GridOf(piece.id.resolution);
  PieceWriter content(symbols, piece, shape, grid);
  content.Write();
  shape.steps = content.StepCount();
  ByteWriter writer;
  WriteHead(writer, piece, shape);
  const std::uint64_t fewest = (DecodedBytes(piece, shape) + mostExpansion - 1) / mostExpansion;
  std::vector<double> bits;
  symbols.Finish(writer, static_cast<std::size_t>(fewest), spent ? &bits : nullptr);
  std::vector<std::uint8_t> blob = writer.Take();
  SealBlob(blob);
  if (spent)
  {
    const auto sum = [&](std::size_t begin, std::size_t end)
    {
      return std::accumulate(
               bits.begin() + std::ptrdiff_t(begin), bits.begin() + std::ptrdiff_t(end), 0.0) /
             8;
    };
    spent->triangles =
      sum(contexts::seed, contexts::groupOf) + sum(contexts::steps, contexts::groupDifference);
    spent->positions = sum(contexts::position, contexts::ownPartition);
    spent->numbers = sum(contexts::groupOf, contexts::samePartition) +
                     sum(contexts::groupDifference, contexts::ghostPartition);
    spent->ghostKeys = sum(contexts::samePartition, contexts::parentOf) +
                       sum(contexts::ghostPartition, contexts::position);
    spent->ancestors =
      sum(contexts::parentOf, contexts::choices) + sum(contexts::ancestor, contexts::childEnd);
    spent->ownKeys = sum(contexts::ownPartition, contexts::ancestor);
    spent->all = double(blob.size());
  }
  return blob;
}

Result<Piece> DecodePiece(
  std::span<const std::uint8_t> blob, PieceId expected, const CodecContext& context)
{
  const auto unsealed = UnsealBlob(blob, pieceMagic);
  if (!unsealed)
  {
    return Named(unsealed.GetError(), expected);
  }
  ByteReader reader(*unsealed);
  Piece piece;
  piece.id = expected;
  PieceShape shape{ expected, context.depths };
  ReadHead(reader, piece, shape);
  if (!reader.Failed())
  {
    const char* wrong = ReadSymbols(
      unsealed->subspan(reader.Position()), piece, shape, context.GridOf(expected.resolution));
    if (wrong)
    {
      reader.Fail(wrong);
    }
  }
  if (reader.Failed())
  {
    return Named(reader.Why(), expected);
  }
  for (const Status& status :
    { CheckPiece(piece, context.depths), CheckRanks(piece, context.depths, context.clusters) })
  {
    if (!status)
    {
      return Named(status.GetError(), expected);
    }
  }
  return piece;
}

}
