// SPDX-License-Identifier: BSD-3-Clause
// Textures in stores: they are added beside the pieces, and come back unchanged.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/codec/TextureTile.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// The texture coordinate of a vertex: the same in every tile.
TileCoordinate CornerAt(const Vec3& point)
{
  return { float(std::nearbyint((point[0] + 2) * 1000) / tileSteps),
    float(std::nearbyint((point[1] + 2) * 1000 + point[2]) / tileSteps) };
}

Attribute TextureArrayOf(const std::string& name, AttributeType type, std::uint8_t components)
{
  Attribute attribute;
  attribute.name = name;
  attribute.type = type;
  attribute.association = AttributeAssociation::Cell;
  attribute.components = components;
  return attribute;
}

void AddColorQuadrics(Mesh& mesh)
{
  Attribute corners = TextureArrayOf(std::string(textureCornersName), AttributeType::Float32, 6);
  Attribute material = TextureArrayOf(std::string(textureMaterialName), AttributeType::UInt32, 1);
  corners.values.resize(mesh.triangles.size() * corners.TupleSize());
  material.values.resize(mesh.triangles.size() * material.TupleSize());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
  {
    for (std::size_t k = 0; k < 6; ++k)
    {
      corners.Set(t, k, double(CornerAt(mesh.points[mesh.triangles[t][k / 2]])[k % 2]));
    }
    material.Set(t, 0, 7);
  }
  mesh.attributes.push_back(corners);
  mesh.attributes.push_back(material);
}

// Tiles whose picture is a few bytes.
class PlainTextures : public PieceTextures
{
public:
  TextureDescription Describe() const override { return { "png" }; }
  Result<EncodedTexture> Make(Piece& piece) const override
  {
    TextureTile tile{ 4000, 4000, TileImage::Png, { 1, 2, 3 }, {} };
    for (const Attribute& array : piece.attributes)
    {
      for (std::size_t t = 0; IsOfCorners(array) && t < piece.triangles.size(); ++t)
      {
        auto& corners = tile.corners.emplace_back();
        for (std::size_t k = 0; k < 6; ++k)
        {
          corners[k / 2][k % 2] = float(array.Get(t, k));
        }
      }
    }
    std::erase_if(piece.attributes, IsTextureArray);
    return EncodedTexture{ EncodeTextureTile(tile, piece.triangles), 16000000 };
  }
};

// More bytes than any store takes.
class TooLarge : public PlainTextures
{
public:
  Result<EncodedTexture> Make(Piece& piece) const override
  {
    Result<EncodedTexture> made = this->PlainTextures::Make(piece);
    made->bytes.resize((std::size_t{ 64 } << 20) + 1);
    return made;
  }
};

TextureTile PlainTileOf(const Piece& piece)
{
  TextureTile tile{ 4000, 4000, TileImage::Png, { 1, 2, 3 }, {} };
  for (const Triangle& t : piece.triangles)
  {
    tile.corners.push_back({ CornerAt(piece.positions[t[0]]), CornerAt(piece.positions[t[1]]),
      CornerAt(piece.positions[t[2]]) });
  }
  return tile;
}

// Textures of levels too. Whenever one is made, the finer ones must be readable.
class TexturesOfLevels : public PlainTextures
{
public:
  TextureDescription Describe() const override
  {
    TextureDescription description{ "png" };
    description.levels = true;
    return description;
  }
  Result<EncodedTexture> MakeOfLevel(const Piece& piece, const FinerPieces& finer) const override
  {
    std::size_t below = 0;
    for (std::size_t i = 0; i < finer.places.size(); ++i)
    {
      const auto read = finer.read(i);
      KDSTREAM_TRY(read);
      EXPECT_TRUE(DecodeTextureTile(read->texture, read->piece.triangles, read->piece.positions));
      below += finer.places[i].below ? read->piece.ownVertices : 0;
    }
    EXPECT_GE(below, piece.ownVertices);
    return EncodedTexture{ EncodeTextureTile(PlainTileOf(piece), piece.triangles), 1000 };
  }
};

BuildOptions Options()
{
  BuildOptions options;
  options.tree.verticesPerPartition = 90;
  options.bits = 0;
  options.textures = std::make_shared<PlainTextures>();
  return options;
}

class StoreTextures : public StoreTest
{
protected:
  void ExpectCorners(const Store& store)
  {
    std::size_t triangles = 0;
    for (std::uint32_t p = 0; p < store.Info().partitions; ++p)
    {
      const auto piece =
        store.ReadPiece({ Resolution::Original(), NodeOfPartition(p, store.Info().depths) });
      const auto blob = store.Read(protocol::BlobId::Texture(p));
      ASSERT_TRUE(piece && blob);
      EXPECT_EQ(*store.Size(protocol::BlobId::Texture(p)), blob->size());
      const auto tile = DecodeTextureTile(*blob, piece->triangles, piece->positions);
      ASSERT_TRUE(tile) << tile.GetError().message;
      for (std::size_t t = 0; t < piece->triangles.size(); ++t)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          ASSERT_EQ(tile->corners[t][k], CornerAt(piece->positions[piece->triangles[t][k]]));
        }
      }
      triangles += piece->triangles.size();
    }
    EXPECT_GE(triangles, store.Info().triangles);
  }

  // Builds the store in memory and out of core, which must give the same.
  void BuildBothWays(BuildOptions options)
  {
    Mesh mesh = Shuffled(DisplacedSphere(5), 4);
    AddColorQuadrics(mesh);
    const std::filesystem::path input = this->File("mesh.ply");
    ASSERT_TRUE(WriteMesh(input, mesh));
    const auto inMemory = BuildStore(input, this->File("memory.kds"), options);
    ASSERT_TRUE(inMemory) << inMemory.GetError().message;
    options.memory = std::uint64_t{ 64 } << 20;
    const auto external = BuildStoreExternally(input, this->File(), options, {}, { {}, 512 << 10 });
    ASSERT_TRUE(external) << external.GetError().message;
    EXPECT_EQ(external->info.digest, inMemory->info.digest);
  }
};

}

TEST_F(StoreTextures, ComeBackWithTheirCorners)
{
  Mesh mesh = Shuffled(DisplacedSphere(4), 3);
  for (VertexId v = 0; v < 200; ++v) // triangles with repeated vertices, in all orders
  {
    const std::array<Triangle, 4> thin{ { { v, v, v + 9 }, { v + 9, v, v }, { v, v + 9, v },
      { v, v, v } } };
    mesh.triangles.insert(mesh.triangles.end(), thin.begin(), thin.end());
  }
  AddColorQuadrics(mesh);
  const BuildReport report = this->Build(mesh, Options());
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  const ModelDescription& info = (*store)->Info();
  ASSERT_TRUE(info.textures);
  EXPECT_EQ(info.textures->format, "png");
  EXPECT_EQ(info.textures->texels, 16000000 * info.partitions);
  EXPECT_TRUE(info.attributes.empty());
  this->ExpectCorners(**store);
  EXPECT_TRUE((*store)->Verify().empty());
  EXPECT_TRUE(
    fixtures::FailsAt((*store)->Read(protocol::BlobId::Texture(std::uint32_t(info.partitions))),
      ErrorCode::NotFound, "textures/" + std::to_string(info.partitions)));
  // An edit of texts keeps the textures.
  ASSERT_TRUE(EditStore(this->File(), { "a title" }));
  const auto edited = Store::Open(this->File());
  ASSERT_TRUE(edited);
  EXPECT_EQ((*edited)->Info().textures, info.textures);
  EXPECT_TRUE((*edited)->Verify().empty());
}

TEST_F(StoreTextures, AreTheSameOutOfCore)
{
  this->BuildBothWays(Options());
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store);
  this->ExpectCorners(**store);
}

// In memory and out of core, with any number of threads: each piece of a level has its own texture.
TEST_F(StoreTextures, LevelsHaveThemToo)
{
  BuildOptions options = Options();
  options.textures = std::make_shared<TexturesOfLevels>();
  this->BuildBothWays(options);

  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  EXPECT_TRUE((*store)->Verify().empty());
  const ModelDescription& info = (*store)->Info();
  ASSERT_TRUE(info.textures && info.textures->levels);
  EXPECT_EQ(info.textures->texels, 16000000 * info.partitions);
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    std::uint64_t bytes = 0;
    const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(depth), info.depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      const auto name = protocol::BlobId::LevelTexture(std::uint8_t(depth), node);
      const auto piece = (*store)->ReadPiece(PieceOfBlob(name, info.depths));
      const auto blob = (*store)->Read(name);
      ASSERT_TRUE(piece && blob);
      bytes += blob->size();
      EXPECT_EQ(*blob, EncodeTextureTile(PlainTileOf(*piece), piece->triangles));
    }
    EXPECT_EQ(info.levels[depth].tileBytes, bytes);
    EXPECT_EQ(info.levels[depth].texels, 1000 * info.levels[depth].pieces);
  }
  EXPECT_TRUE(fixtures::FailsAt((*store)->Read(protocol::BlobId::LevelTexture(3, 2)),
    ErrorCode::NotFound, "level-textures/3/2"));

  StoreContent content(this->File());
  content.FirstByteOf("level-textures/3/1") ^= 1;
  content.Write();
  const auto damaged = Store::Open(this->File());
  ASSERT_TRUE(damaged);
  const std::vector<Error> found = (*damaged)->Verify();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(fixtures::IsAt(found[0], ErrorCode::Damaged, "level-textures/3/1"));
}

TEST_F(StoreTextures, PlainStoresHaveNone)
{
  BuildOptions options = Options();
  options.textures = nullptr;
  this->Build(DisplacedSphere(3), options);
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store);
  EXPECT_FALSE((*store)->Info().textures);
  EXPECT_EQ((*store)->Read(protocol::BlobId::Texture(0)).GetError().code, ErrorCode::NotFound);
  EXPECT_EQ((*store)->Size(protocol::BlobId::Texture(0)).GetError().code, ErrorCode::NotFound);
}

TEST_F(StoreTextures, DamageIsNamed)
{
  Mesh mesh = DisplacedSphere(3);
  AddColorQuadrics(mesh);
  this->Build(mesh, Options());
  StoreContent content(this->File());
  content.FirstByteOf("textures/2") ^= 1;
  content.PlaceOf("textures/3").checksum ^= 1;
  content.Write();
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store);
  const std::vector<Error> found = (*store)->Verify();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(IsAt(found[0], ErrorCode::Damaged, "textures/2"));
  EXPECT_TRUE(IsAt(found[1], ErrorCode::Damaged, "textures/3"));
}

TEST_F(StoreTextures, TooLargeOnesAreRefused)
{
  Mesh mesh = DisplacedSphere(2);
  AddColorQuadrics(mesh);
  BuildOptions options = Options();
  options.textures = std::make_shared<TooLarge>();
  const auto report = BuildStore(mesh, "mesh.ply", this->File(), options);
  ASSERT_FALSE(report);
  EXPECT_TRUE(FailsAt(report, ErrorCode::LimitExceeded, "textures/0"));
}
