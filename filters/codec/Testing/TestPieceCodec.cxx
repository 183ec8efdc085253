// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/codec/ByteStream.h"
#include "filters/codec/PackedTriangles.h"
#include "filters/codec/PieceCodec.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/Seal.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/Testing/RandomPiece.h"
#include "filters/core/Weld.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <map>
#include <new>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// Bytes allocated by operator new since the last reset, to measure what a decoder allocates.
std::atomic<std::size_t> allocated{ 0 };

}

// Not inlined, because g++ would then warn that malloc and delete do not match.
[[gnu::noinline]] void* operator new(std::size_t size)
{
  allocated += size;
  if (void* memory = std::malloc(size))
  {
    return memory;
  }
  throw std::bad_alloc();
}
// std::stable_sort allocates its buffer with this one.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
  allocated += size;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}

namespace
{

std::vector<CodecContext> ContextsOf(const Model& model)
{
  const Box box = BoxOfPoints(model.mesh.points);
  const TreeDepths& depths = model.tree.depths;
  const ScalarType type = model.mesh.scalarType;
  std::vector<std::uint32_t> spacings; // a different one for each level
  for (unsigned depth = 0; depth <= depths.finest; ++depth)
  {
    spacings.push_back(1 + (depths.finest - depth) * 333);
  }
  return { { depths, CoordinateGrid::Over(box, 20, type), {} },
    { depths, CoordinateGrid::Over(box, 20, type), spacings },
    { depths, CoordinateGrid::Over(box, 8, type), {} },
    { depths, CoordinateGrid::Exact(type), spacings } };
}

void ExpectSame(const Piece& decoded, const Piece& piece, const CoordinateGrid& grid)
{
  ASSERT_EQ(decoded.id, piece.id);
  ASSERT_EQ(decoded.primitive, piece.primitive);
  ASSERT_EQ(decoded.ownVertices, piece.ownVertices);
  ASSERT_EQ(decoded.keys, piece.keys);
  ASSERT_TRUE(decoded.geometricErrors.empty());
  ASSERT_EQ(decoded.ancestors, piece.ancestors);
  ASSERT_EQ(decoded.childBegin, piece.childBegin);
  ASSERT_EQ(decoded.childNodes, piece.childNodes);
  ASSERT_EQ(decoded.triangles, piece.triangles);
  ASSERT_EQ(decoded.attributes, piece.attributes);
  ASSERT_EQ(decoded.positions.size(), piece.positions.size());
  for (std::size_t v = 0; v < piece.positions.size(); ++v)
  {
    ASSERT_EQ(BitsOf(decoded.positions[v]), BitsOf(grid.Snap(piece.positions[v])));
    for (std::size_t k = 0; !grid.Lossless() && k < 3; ++k)
    {
      ASSERT_LE(std::abs(decoded.positions[v][k] - piece.positions[v][k]),
        0.5001 * grid.step * grid.spacing);
    }
  }
}

// The blob's first `size` bytes with a correct checksum, so that they get past the check.
std::vector<std::uint8_t> SealedPart(std::span<const std::uint8_t> blob, std::size_t size)
{
  std::vector<std::uint8_t> part(blob.begin(), blob.begin() + std::ptrdiff_t(size));
  SealBlob(part);
  return part;
}

Piece WithAttributes(Piece piece)
{
  std::mt19937 random(1);
  const auto add = [&](const char* name, AttributeType type, AttributeAssociation association,
                     std::uint8_t components)
  {
    Attribute attribute{ name, type, association, components, {} };
    const std::size_t tuples =
      association == AttributeAssociation::Point ? piece.positions.size() : piece.triangles.size();
    attribute.values.resize(tuples * components * SizeOf(type));
    for (std::uint8_t& value : attribute.values)
    {
      value = static_cast<std::uint8_t>(random());
    }
    piece.attributes.push_back(std::move(attribute));
  };
  add("RGB", AttributeType::UInt8, AttributeAssociation::Point, 3);
  add("area", AttributeType::Float64, AttributeAssociation::Cell, 1);
  add("Normals", AttributeType::Float32, AttributeAssociation::Point, 3);
  return piece;
}

// A piece of many vertices and few triangles that are spread over the vertices, some repeated or
// degenerate, with and without the last vertex.
Piece MostlyIsolated(std::uint32_t count, std::mt19937& random)
{
  Piece piece;
  piece.id = { Resolution::Original(), 1 };
  piece.ownVertices = count;
  for (std::uint32_t v = 0; v < count; ++v)
  {
    piece.keys.push_back(MakeKey(0, v));
    piece.positions.push_back({ double(v % 2048), double(v / 2048), 0 });
  }
  for (unsigned i = 0; i < 4000; ++i)
  {
    const auto v = static_cast<VertexId>(random() % count);
    const auto w = static_cast<VertexId>(random() % count);
    piece.triangles.push_back(RotateLowestFirst({ count - 1, v, w }));
    piece.triangles.push_back(RotateLowestFirst({ w, v, i % 8 == 0 ? v : w / 2 }));
    if (i % 5 == 0)
    {
      const Triangle again = piece.triangles[random() % piece.triangles.size()];
      piece.triangles.push_back(again);
    }
  }
  std::sort(piece.triangles.begin(), piece.triangles.end());
  return piece;
}

}

TEST(PieceCodec, EveryPieceOfEveryMeshComesBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const auto model = MakeModel(named.mesh, { 150, {}, 8 });
    for (const CodecContext& context : ContextsOf(*model))
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(context.grid.bits) + " bits");
      for (const auto& [id, piece] : model->pieces)
      {
        const auto blob = EncodePiece(piece, context);
        const Result<Piece> decoded = DecodePiece(blob, id, context);
        ASSERT_TRUE(decoded) << decoded.GetError().message;
        ExpectSame(*decoded, piece, context.GridOf(piece.id.resolution));
        ASSERT_EQ(EncodePiece(*decoded, context), blob) << "encoding again gives other bytes";
      }
    }
  }
}

TEST(PieceCodec, AttributesComeBack)
{
  const auto model = MakeModel(Torus(40, 20), { 150, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  for (const auto& [id, plain] : model->pieces)
  {
    const Piece piece = WithAttributes(plain);
    const Result<Piece> decoded = DecodePiece(EncodePiece(piece, context), id, context);
    ASSERT_TRUE(decoded) << decoded.GetError().message;
    EXPECT_EQ(decoded->attributes, piece.attributes);
  }
}

// Coarse colours are of 16 steps, and only those of levels; everything else is the same.
TEST(PieceCodec, CoarseColorsAreRounded)
{
  const auto model = MakeModel(Torus(40, 20), { 150, {}, 8 });
  CodecContext context = ContextsOf(*model)[0];
  for (const auto& [id, plain] : model->pieces)
  {
    const Piece piece = WithAttributes(plain);
    context.coarseColors = false;
    const std::size_t fine = EncodePiece(piece, context).size();
    context.coarseColors = true;
    const auto blob = EncodePiece(piece, context);
    const Result<Piece> decoded = DecodePiece(blob, id, context);
    ASSERT_TRUE(decoded) << decoded.GetError().message;
    EXPECT_EQ(EncodePiece(*decoded, context), blob);
    EXPECT_EQ(decoded->attributes[1], piece.attributes[1]);
    EXPECT_EQ(decoded->attributes[2], piece.attributes[2]);
    const auto &before = piece.attributes[0].values, &after = decoded->attributes[0].values;
    ASSERT_EQ(before.size(), after.size());
    if (id.resolution.IsOriginal())
    {
      EXPECT_EQ(after, before);
      continue;
    }
    EXPECT_TRUE(piece.VertexCount() < 20 || blob.size() + piece.VertexCount() < fine);
    for (std::size_t i = 0; i < after.size(); ++i)
    {
      ASSERT_EQ(after[i] % 17, 0);
      ASSERT_LE(std::abs(int{ after[i] } - int{ before[i] }), 8);
    }
  }
}

TEST(PieceCodec, AttributesThatNoBuilderWritesAreRefused)
{
  const auto model = MakeModel(Torus(20, 10), { 60, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  const auto& [id, plain] = *model->pieces.rbegin();
  const auto expectRefused = [&, &id = id, &plain = plain](const auto& change)
  {
    Piece piece = WithAttributes(plain);
    change(piece.attributes);
    const Result<Piece> decoded = DecodePiece(EncodePiece(piece, context), id, context);
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.GetError().code, ErrorCode::InvalidInput);
    EXPECT_NE(decoded.GetError().message.find("attribute"), std::string::npos)
      << decoded.GetError().message;
  };
  using Attributes = std::vector<Attribute>;
  expectRefused([](Attributes& a) { a[0].name.clear(); });
  expectRefused(
    [](Attributes& a)
    {
      a[0].components = 0;
      a[0].values.clear();
    });
  expectRefused([](Attributes& a) { a.push_back(a[0]); });
}

TEST(PieceCodec, EveryTruncationThatIsSealedAgainIsAnError)
{
  const auto model = MakeModel(Torus(20, 10), { 60, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  for (const auto& [id, piece] : model->pieces)
  {
    const auto blob = EncodePiece(WithAttributes(piece), context);
    const std::size_t content = blob.size() - checksumSize;
    for (std::size_t size = 0; size < content; ++size)
    {
      const Result<Piece> decoded = DecodePiece(SealedPart(blob, size), id, context);
      ASSERT_FALSE(decoded) << size << " of " << content << " bytes";
      ASSERT_TRUE(size < blobHeadSize || decoded.GetError().code == ErrorCode::InvalidInput)
        << decoded.GetError().message;
    }
    auto longer = blob;
    longer[content] = 0;
    longer = SealedPart(longer, content + 1);
    const Result<Piece> decoded = DecodePiece(longer, id, context);
    ASSERT_FALSE(decoded);
    EXPECT_NE(decoded.GetError().message.find("extra bytes at the end"), std::string::npos)
      << decoded.GetError().message;
  }
}

TEST(PieceCodec, AlteredBytesNeverCrashNorTakeMemoryThatIsNotThere)
{
  const auto model = MakeModel(Torus(40, 20), { 150, {}, 8 });
  std::mt19937 random(99);
  for (const CodecContext& context : ContextsOf(*model))
  {
    for (const auto& [id, piece] : model->pieces)
    {
      const auto blob = EncodePiece(WithAttributes(piece), context);
      for (unsigned i = 0; i < 60; ++i)
      {
        auto altered = blob;
        altered.resize(blob.size() - checksumSize);
        for (unsigned j = 0; j <= i % 4; ++j)
        {
          // Every second change is in the head, where the counts are.
          const std::size_t at =
            random() % (j % 2 == 0 ? std::min<std::size_t>(24, altered.size()) : altered.size());
          altered[at] = static_cast<std::uint8_t>(random() % 3 == 0 ? 255 : random());
        }
        SealBlob(altered);
        allocated = 0;
        const Result<Piece> decoded = DecodePiece(altered, id, context);
        ASSERT_LT(allocated, 1024 * altered.size() + 65536);
        if (decoded)
        {
          ASSERT_TRUE(CheckPiece(*decoded, context.depths));
        }
      }
    }
  }
}

TEST(PieceCodec, SaysWhatItDoesNotKnow)
{
  const auto model = MakeModel(Torus(20, 10), { 60, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  const PieceId id{ Resolution::Level(0), 1 };
  auto blob = EncodePiece(model->pieces.at(id), context);
  blob[3] = 77;
  EXPECT_TRUE(FailsAt(DecodePiece(blob, id, context), ErrorCode::Unsupported, "piece 1"));
  blob[0] = 'X';
  EXPECT_TRUE(FailsAt(DecodePiece(blob, id, context), ErrorCode::InvalidInput, "piece 1"));
  const auto original = model->pieces.rbegin()->second;
  EXPECT_FALSE(DecodePiece(EncodePiece(original, context), id, context))
    << "a blob in the wrong place";
}

TEST(CoordinateGrid, CoversTheBoxInEqualSteps)
{
  const Box box{ { -1, 2, 4e6 }, { 1, 2.5, 4e6 + 0.25 } };
  const auto grid = CoordinateGrid::Over(box, 20, ScalarType::Float64);
  EXPECT_DOUBLE_EQ(grid.step, 2.0 / ((1 << 20) - 1));
  EXPECT_EQ(grid.Quantize(box.lo), (std::array<std::uint32_t, 3>{ 0, 0, 0 }));
  EXPECT_EQ(grid.Quantize(box.hi)[0], (1U << 20) - 1);
  EXPECT_EQ(grid.Quantize({ -100, 100, 0 }), (std::array<std::uint32_t, 3>{ 0, (1U << 20) - 1, 0 }))
    << "clamped";
  EXPECT_EQ(CoordinateGrid::Over({ { 3, 3, 3 }, { 3, 3, 3 } }, 20, ScalarType::Float32).step, 1.0);
}

TEST(ByteStream, OrderedBitsKeepTheOrderOfNumbers)
{
  const std::vector<double> ascending{ -INFINITY, -1e300, -2.5, -1e-310, -0.0, 0.0, 1e-310, 1,
    1e300, INFINITY };
  for (std::size_t i = 0; i < ascending.size(); ++i)
  {
    EXPECT_EQ(BitsOf({ DoubleOfOrderedBits(OrderedBits(ascending[i])), 0, 0 }),
      BitsOf({ ascending[i], 0, 0 }));
    const auto f = static_cast<float>(ascending[i]);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(FloatOfOrderedBits(OrderedBits(f))),
      std::bit_cast<std::uint32_t>(f));
    if (i > 0)
    {
      EXPECT_LT(OrderedBits(ascending[i - 1]), OrderedBits(ascending[i]));
    }
  }
}

TEST(PieceCodec, ANumberBeyond32BitsIsNotASmallOne)
{
  // Writes a piece of level 0 with one vertex, of this rank, symbol by symbol.
  const auto blobWith = [](std::uint64_t rank)
  {
    ByteWriter writer;
    WriteBlobHead(writer, "KDP");
    writer.Byte(1); // triangles
    // own, ghosts, triangles, steps, attributes
    for (const std::uint64_t count : { 1, 0, 0, 0, 0 })
    {
      writer.Varint(count);
    }
    SymbolWriter symbols({ contexts::choices, contexts::attribute });
    symbols.Number(contexts::single, 8); // the position's mode
    symbols.Number(contexts::single, 0);
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      symbols.Signed(contexts::unguidedPosition, 100);
    }
    symbols.Choice(contexts::groupOf + 7, 3);
    symbols.Signed(contexts::groupDifference, 0);
    symbols.Number(contexts::single, rank);
    symbols.Finish(writer, 0);
    std::vector<std::uint8_t> blob = writer.Take();
    SealBlob(blob);
    return blob;
  };
  const CodecContext context{ { 1, 2, 2 },
    CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 8, ScalarType::Float32) };
  const PieceId id{ Resolution::Level(0), 1 };
  const Result<Piece> good = DecodePiece(blobWith(7), id, context);
  ASSERT_TRUE(good) << good.GetError().message;
  EXPECT_EQ(good->keys, std::vector<VertexKey>{ 7 });
  const Result<Piece> decoded = DecodePiece(blobWith((std::uint64_t{ 1 } << 32) + 7), id, context);
  ASSERT_FALSE(decoded);
  EXPECT_NE(decoded.GetError().message.find("keys out of range"), std::string::npos)
    << decoded.GetError().message;
}

// A bent sheet of side * side vertices: level 3 of a model with S = 4 and R = 1, or only its
// points. Four vertices in a square have one parent, and so do four of these parents.
Piece BentSheet(std::uint32_t side, bool triangles)
{
  Piece piece;
  piece.id = { Resolution::Level(3), 1 };
  piece.ownVertices = side * side;
  for (std::uint32_t v = 0; v < side * side; ++v)
  {
    const std::uint32_t x = v % side, y = v / side;
    const double u = (x + (x * y * 7 % 5) * 0.13) / side, w = (y + (x * y * 11 % 7) * 0.09) / side;
    piece.keys.push_back(v);
    piece.positions.push_back({ u, w, 0.4 * u * w + 0.2 * u * u });
    piece.ancestors.push_back(y / 4 * (side / 4) + x / 4);
    piece.ancestors.push_back(y / 2 * (side / 2) + x / 2);
    piece.childBegin.push_back(v);
    piece.childNodes.push_back(1);
    if (triangles && x + 1 < side && y + 1 < side)
    {
      piece.triangles.push_back({ v, v + 1, v + side + 1 });
      piece.triangles.push_back({ v, v + side + 1, v + side });
    }
  }
  piece.childBegin.push_back(side * side);
  std::sort(piece.triangles.begin(), piece.triangles.end());
  return piece;
}

TEST(PieceCodec, EdgesNameVerticesOfOneParent)
{
  const CodecContext context{ { 0, 4, 5, 1 },
    CoordinateGrid::Over({ { 0, 0, 0 }, { 1.1, 1.1, 1 } }, 16, ScalarType::Float32) };
  EncodedBytes withEdges, without;
  for (EncodedBytes* spent : { &withEdges, &without })
  {
    const Piece piece = BentSheet(32, spent == &withEdges);
    ASSERT_TRUE(CheckPiece(piece, context.depths))
      << CheckPiece(piece, context.depths).GetError().message;
    const Result<Piece> decoded =
      DecodePiece(EncodePiece(piece, context, spent), piece.id, context);
    ASSERT_TRUE(decoded) << decoded.GetError().message;
    ExpectSame(*decoded, piece, context.grid);
  }
  EXPECT_LT(withEdges.ancestors, 0.7 * without.ancestors);
}

TEST(PieceCodec, ASmoothLevelIsCodedByPlanes)
{
  const CodecContext context{ { 0, 4, 5, 1 },
    CoordinateGrid::Over({ { 0, 0, 0 }, { 1.1, 1.1, 1 } }, 16, ScalarType::Float32) };
  const Piece level = BentSheet(32, true);
  Piece original = level;
  original.id = { Resolution::Original(), 1 };
  original.ancestors.clear();
  original.childBegin.clear();
  original.childNodes.clear();
  EncodedBytes ofLevel, ofOriginal; // the original is never coded by planes
  (void)EncodePiece(level, context, &ofLevel);
  (void)EncodePiece(original, context, &ofOriginal);
  EXPECT_LT(ofLevel.positions, 0.95 * ofOriginal.positions);
}

TEST(PieceCodec, PiecesOfAnythingComeBack)
{
  std::mt19937 random(6);
  for (unsigned i = 0; i < 3000; ++i)
  {
    const auto partition = static_cast<unsigned>(random() % 4);
    const unsigned stitch = partition + static_cast<unsigned>(random() % 5);
    const TreeDepths depths{ partition, stitch, stitch + static_cast<unsigned>(random() % 14),
      static_cast<unsigned>(random() % 5) };
    Piece piece = RandomPiece(random, depths);
    if (i % 8 == 0)
    {
      piece = WithEveryAttribute(std::move(piece), random);
    }
    const Status status = CheckPiece(piece, depths);
    ASSERT_TRUE(status) << "the test's own piece: " << status.GetError().message;
    for (const CoordinateGrid& grid :
      { CoordinateGrid::Exact(ScalarType::Float64), CoordinateGrid::Exact(ScalarType::Float32),
        CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 8, ScalarType::Float32),
        CoordinateGrid::Over({ { 0, 0, 0 }, { 1, 1, 1 } }, 24, ScalarType::Float64) })
    {
      SCOPED_TRACE("piece " + std::to_string(i) + ", " + std::to_string(grid.bits) + " bits");
      const CodecContext context{ depths, grid,
        std::vector<std::uint32_t>(depths.finest + 1, 1 + i % 2 * 50) };
      const auto blob = EncodePiece(piece, context);
      const Result<Piece> decoded = DecodePiece(blob, piece.id, context);
      ASSERT_TRUE(decoded) << decoded.GetError().message;
      ExpectSame(*decoded, piece, context.GridOf(piece.id.resolution));
      ASSERT_EQ(EncodePiece(*decoded, context), blob) << "encoding again gives other bytes";
    }
  }
}

TEST(PieceCodec, RanksBeyondTheirLevelAreRefused)
{
  const auto model = MakeModel(Torus(60, 40), { 20, {}, 2 }, {}, {}, 3);
  CodecContext context = ContextsOf(*model)[0];
  std::map<unsigned, std::uint64_t> clusters;
  for (const auto& [id, piece] : model->pieces)
  {
    if (!id.resolution.IsOriginal())
    {
      clusters[id.resolution.Depth()] += piece.ownVertices;
    }
  }
  for (const auto& [level, count] : clusters)
  {
    context.clusters.push_back(count);
  }
  std::set<std::string> reasons;
  for (const auto& [id, piece] : model->pieces)
  {
    const auto blob = EncodePiece(piece, context);
    ASSERT_TRUE(DecodePiece(blob, id, context));
    for (std::size_t level = 0; level < context.clusters.size(); ++level)
    {
      CodecContext fewer = context;
      fewer.clusters[level] = 0;
      if (const auto reported = DecodePiece(blob, id, fewer); !reported)
      {
        EXPECT_EQ(reported.GetError().code, ErrorCode::InvalidInput);
        const std::string& why = reported.GetError().message;
        EXPECT_EQ(why.rfind("piece " + std::to_string(id.node) + " of ", 0), 0U) << why;
        const std::size_t ofAncestor = why.find(" of an ancestor");
        reasons.insert(why.substr(std::min(ofAncestor, why.find(" is beyond"))));
      }
    }
  }
  EXPECT_EQ(reasons,
    (std::set<std::string>{ " is beyond its level", " of an ancestor is beyond its level" }));
}

TEST(PieceCodec, WhatIsTooRegularToFillItsBlobComesBack)
{
  const auto model = MakeModel(Torus(40, 20), { 150, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  Piece piece = model->pieces.rbegin()->second;
  Attribute zeros{ "zeros", AttributeType::UInt64, AttributeAssociation::Point, 255, {} };
  zeros.values.resize(piece.positions.size() * zeros.TupleSize());
  piece.attributes.push_back(zeros);
  const auto blob = EncodePiece(piece, context);
  EXPECT_GE(blob.size(), zeros.values.size() / 128) << "a blob bounds what it makes of itself";
  const Result<Piece> decoded = DecodePiece(blob, piece.id, context);
  ASSERT_TRUE(decoded) << decoded.GetError().message;
  ExpectSame(*decoded, piece, context.GridOf(piece.id.resolution));
}

TEST(PieceCodec, MoreThan65536VerticesComeBack)
{
  const auto model = MakeModel(Shuffled(GridPlate(270), 3), { 100000, {}, 8 });
  const CodecContext context = ContextsOf(*model)[0];
  const Piece& piece = model->pieces.rbegin()->second;
  ASSERT_GT(piece.ownVertices, 65536U);
  const auto blob = EncodePiece(piece, context);
  const Result<Piece> decoded = DecodePiece(blob, piece.id, context);
  ASSERT_TRUE(decoded) << decoded.GetError().message;
  ExpectSame(*decoded, piece, context.GridOf(piece.id.resolution));
  allocated = 0;
  ASSERT_TRUE(DecodePiece(blob, piece.id, context));
  EXPECT_LT(allocated, 2048 * blob.size()) << "the blob is padded to bound the reader's memory";
}

// Up to this number of vertices a triangle's corners are sorted as one number; with more vertices
// they are not.
TEST(PieceCodec, PiecesAboutTheMostVerticesThatFitPackedTrianglesComeBack)
{
  constexpr std::uint32_t most = 1U << PackedTriangles::bits;
  for (const std::uint32_t count : { most, most + 1 })
  {
    SCOPED_TRACE(std::to_string(count) + " vertices");
    std::mt19937 random(8);
    const Piece piece = MostlyIsolated(count, random);
    const CodecContext context{ { 0, 0, 4 }, CoordinateGrid::Exact(ScalarType::Float32) };
    const Status status = CheckPiece(piece, context.depths);
    ASSERT_TRUE(status) << "the test's own piece: " << status.GetError().message;
    const auto blob = EncodePiece(piece, context);
    const Result<Piece> decoded = DecodePiece(blob, piece.id, context);
    ASSERT_TRUE(decoded) << decoded.GetError().message;
    ExpectSame(*decoded, piece, context.GridOf(piece.id.resolution));
  }
}

TEST(ByteStream, IntegersOfAnySizeComeBack)
{
  std::mt19937_64 random(4);
  for (unsigned bits = 0; bits <= 64; ++bits)
  {
    std::vector<std::uint64_t> values(random() % 50);
    ByteWriter writer;
    for (std::uint64_t& value : values)
    {
      value = bits == 0 ? 0 : random() >> (64 - bits);
      writer.Varint(value);
    }
    const auto bytes = writer.Take();
    ByteReader reader(bytes);
    for (const std::uint64_t value : values)
    {
      EXPECT_EQ(reader.Varint(~std::uint64_t{ 0 }), value);
    }
    EXPECT_FALSE(reader.Failed());
    EXPECT_EQ(reader.Remaining(), 0U);
  }
}
