// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses: nothing that is displayed depends on them, and they come back
// unchanged, whichever builder wrote the store.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"
#include "filters/store/UnusedList.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numeric>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

BuildOptions Options(bool lossless = false)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 90;
  options.bits = lossless ? 0 : 20;
  options.weld = !lossless;
  return options;
}

// A mesh as from a survey: in metres, far from the origin.
Mesh Survey()
{
  Mesh mesh = Shuffled(HeightField(40), 3);
  mesh.scalarType = ScalarType::Float64;
  for (Vec3& point : mesh.points)
  {
    point = { point[0] * 100 + 412345.25, point[1] * 100 + 5312345.5, point[2] * 100 + 512 };
  }
  return mesh;
}

// The mesh with additional vertices that no triangle uses, before, among and after the others.
Mesh WithStrays(const Mesh& mesh, const std::vector<Vec3>& strays)
{
  Mesh all{ {}, {}, mesh.scalarType, {} };
  std::vector<VertexId> numbers;
  std::size_t next = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (; next * mesh.points.size() <= v * strays.size() && next < strays.size(); ++next)
    {
      all.points.push_back(strays[next]);
    }
    numbers.push_back(static_cast<VertexId>(all.points.size()));
    all.points.push_back(mesh.points[v]);
  }
  all.points.insert(all.points.end(), strays.begin() + std::ptrdiff_t(next), strays.end());
  for (const Triangle& t : mesh.triangles)
  {
    all.triangles.push_back({ numbers[t[0]], numbers[t[1]], numbers[t[2]] });
  }
  return all;
}

std::vector<Vec3> RandomPoints(std::size_t count, double range)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-range, range);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
  {
    points.push_back({ coordinate(random), coordinate(random), coordinate(random) });
  }
  return points;
}

Mesh Original(const Store& store)
{
  std::vector<std::uint32_t> all(store.Info().partitions);
  std::iota(all.begin(), all.end(), 0U);
  Result<Mesh> mesh = GlueStoreMesh(store, all);
  EXPECT_TRUE(mesh) << mesh.GetError().message;
  const Status added = AddUnused(store, *mesh);
  EXPECT_TRUE(added) << added.GetError().message;
  return std::move(*mesh);
}

// Two stores must look the same to a viewer.
void ExpectSameLooks(const Store& a, const Store& b)
{
  ModelDescription one = a.Info(), other = b.Info();
  for (ModelDescription* const info : { &one, &other })
  {
    info->digest.clear();
    info->inputDigest.clear();
    info->unused.reset();
  }
  EXPECT_EQ(one, other);
  for (const PieceId id : a.PieceIds())
  {
    ASSERT_EQ(*a.Read(BlobOfPiece(id, a.Info().depths)), *b.Read(BlobOfPiece(id, b.Info().depths)))
      << id.node;
  }
  for (const NodeId page : TreePages(a.Info().depths))
  {
    ASSERT_EQ(*a.Read(protocol::BlobId::TreePage(page)), *b.Read(protocol::BlobId::TreePage(page)));
  }
  for (const NodeId node : AllPartitionBoxes(a.Info().depths))
  {
    ASSERT_EQ(*a.Read(protocol::BlobId::PartitionBoxes(node)),
      *b.Read(protocol::BlobId::PartitionBoxes(node)));
  }
}

class StoreUnused : public StoreTest
{
protected:
  std::shared_ptr<Store> Open(const std::string& name = "model.kds")
  {
    auto store = Store::Open(this->File(name));
    EXPECT_TRUE(store) << store.GetError().message;
    return store ? *store : nullptr;
  }

  // What Verify reports after the change, or why the store cannot be opened.
  std::vector<std::string> DamageOf(const std::function<void()>& change)
  {
    std::filesystem::copy_file(this->File(), this->File("good"));
    change();
    const auto store = Store::Open(this->File());
    std::vector<std::string> messages;
    for (const Error& error : store ? (*store)->Verify() : std::vector<Error>{ store.GetError() })
    {
      messages.push_back(error.message);
    }
    std::filesystem::rename(this->File("good"), this->File());
    return messages;
  }
};

}

TEST_F(StoreUnused, AScanWithOneStrayVertexLooksAsWithoutIt)
{
  const Mesh survey = Survey();
  for (const PartitionMethod* const partitioner :
    { &KdTreeMethod(), &OctreeMethod(), &KMeansMethod() })
  {
    BuildOptions options = Options();
    options.partitioner = partitioner;
    this->Build(survey, options);
    std::filesystem::rename(this->File(), this->File("without"));
    const BuildReport report = this->Build(WithStrays(survey, { { 0, 0, 0 } }), options);
    EXPECT_EQ(report.mergedByGrid, 0U);
    const auto with = this->Open(), without = this->Open("without");
    ExpectSameLooks(*with, *without);
    ASSERT_TRUE(with->Info().unused);
    EXPECT_EQ(with->Info().unused->vertices, 1U);
    EXPECT_EQ(with->Info().unused->farthest, (Vec3{ 0, 0, 0 }));
    EXPECT_NE(with->Info().digest, without->Info().digest);
    EXPECT_TRUE(with->Verify().empty());
    const Result<Piece> part = with->ReadUnused(0);
    ASSERT_TRUE(part);
    EXPECT_EQ(part->positions, (std::vector<Vec3>{ { 0, 0, 0 } }));
  }
}

// Vertices within the box come back too: they are not vertices of the surface either.
TEST_F(StoreUnused, TheyComeBackExactlyWhereverTheyLie)
{
  const Mesh survey = Survey();
  std::vector<Vec3> strays = RandomPoints(300, 1e7);
  strays.insert(strays.end(), { { 0, -0.0, 0 }, { 1e300, -1e300, 5e-324 }, { 412350, 5312350, 512 },
                                { 1, 2, 3 }, { 1, 2, 3 } });
  const Mesh mesh = WithAttributes(WithStrays(survey, strays), 5);
  for (const bool lossless : { true, false })
  {
    this->Build(mesh, Options(lossless));
    const auto store = this->Open();
    ASSERT_TRUE(store->Info().unused);
    EXPECT_EQ(store->Info().unused->vertices, strays.size());
    EXPECT_EQ(store->Info().unused->farthest, (Vec3{ 1e300, -1e300, 5e-324 }));
    EXPECT_EQ(store->Info().vertices, survey.points.size());
    EXPECT_TRUE(store->Verify().empty());
    const Mesh original = Original(*store);
    EXPECT_EQ(original.points.size(), mesh.points.size());
    const Mesh alone{ { original.points.end() - std::ptrdiff_t(strays.size()),
                        original.points.end() },
      {}, mesh.scalarType, {} };
    EXPECT_EQ(ContentOf(alone), ContentOf({ strays, {}, mesh.scalarType, {} }));
    if (lossless)
    {
      EXPECT_EQ(ContentOf(original), ContentOf(mesh));
    }
  }
}

TEST_F(StoreUnused, VeryManyAreSeveralParts)
{
  const std::vector<Vec3> strays = RandomPoints(20000, 1e6);
  const Mesh mesh = WithStrays(Survey(), strays);
  this->Build(mesh, Options(true));
  const auto store = this->Open();
  EXPECT_EQ(UnusedPartCount(store->Info()), 3U);
  EXPECT_EQ(store->ReadUnused(0)->positions.size(), 8192U);
  EXPECT_EQ(store->ReadUnused(3).GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(ContentOf(Original(*store)), ContentOf(mesh));
  EXPECT_TRUE(store->Verify().empty());
}

TEST_F(StoreUnused, OutOfCoreTheStoreIsTheSame)
{
  for (const bool lossless : { true, false })
  {
    for (const bool attributes : { true, false })
    {
      SCOPED_TRACE(
        std::string(lossless ? "lossless" : "welded") + (attributes ? ", attributes" : ""));
      std::vector<Vec3> strays = RandomPoints(9000, 1e6);
      strays.insert(strays.end(), strays.begin(), strays.begin() + 500); // welded to each other
      Mesh mesh = WithStrays(Survey(), strays);
      mesh.points.push_back(mesh.points[mesh.triangles[0][0]]); // welded to one that is used
      mesh = attributes ? WithAttributes(mesh, 3) : mesh;
      ASSERT_TRUE(WriteMesh(this->File("mesh.ply"), mesh));
      BuildOptions options = Options(lossless);
      const auto inMemory = BuildStore(this->File("mesh.ply"), this->File("memory.kds"), options);
      ASSERT_TRUE(inMemory) << inMemory.GetError().message;
      options.memory = std::uint64_t{ 64 } << 20;
      const auto external = BuildStoreExternally(
        this->File("mesh.ply"), this->File(), options, {}, { {}, std::uint64_t{ 128 } << 10 });
      ASSERT_TRUE(external) << external.GetError().message;
      EXPECT_EQ(external->info, inMemory->info);
      EXPECT_TRUE(this->Bytes("memory.kds") == this->Bytes("model.kds"));
      if (!attributes)
      {
        EXPECT_EQ(inMemory->info.unused->vertices, lossless ? strays.size() + 1 : 9000);
      }
    }
  }
}

TEST_F(StoreUnused, PlainStoresAndCloudsHaveNone)
{
  Mesh cloud = Survey();
  cloud.triangles.clear();
  for (const Mesh& mesh : { Survey(), cloud })
  {
    this->Build(mesh, Options());
    const auto store = this->Open();
    EXPECT_FALSE(store->Info().unused);
    EXPECT_EQ(store->ReadUnused(0).GetError().code, ErrorCode::NotFound);
  }
}

TEST_F(StoreUnused, TextsAreChangedWithoutThem)
{
  this->Build(WithStrays(Survey(), RandomPoints(20, 5)), Options());
  const auto before = this->Open();
  ASSERT_TRUE(before->Info().unused);
  ASSERT_TRUE(EditStore(this->File(), { "a title" }));
  const auto edited = this->Open();
  EXPECT_EQ(edited->Info().unused, before->Info().unused);
  EXPECT_EQ(edited->Info().digest, before->Info().digest);
  EXPECT_TRUE(edited->Verify().empty());
}

TEST_F(StoreUnused, DamageIsNamed)
{
  using Messages = std::vector<std::string>;
  const Mesh mesh = WithStrays(Survey(), RandomPoints(20000, 1e6));
  this->Build(mesh, Options());
  const auto put = [&](const std::function<void(StoreContent&)>& change)
  {
    return this->DamageOf(
      [&]
      {
        StoreContent content(this->File());
        change(content);
        content.Write();
      });
  };
  EXPECT_EQ(put([](StoreContent& content) { content.FirstByteOf("unused/1") ^= 1; }),
    Messages{ "unused/1: wrong checksum" });
  EXPECT_EQ(put([](StoreContent& content) { content.Places.pop_back(); }),
    Messages{ "unused/2: row is missing" });
  // In place of the first part: the last one, which is shorter; then a piece of the surface.
  const std::vector<std::uint8_t> last = *this->Open()->ReadUnusedBlob(2);
  const auto putFirst = [&](std::span<const std::uint8_t> data)
  { return put([&](StoreContent& content) { content.Replace("unused/0", data); }); };
  EXPECT_EQ(
    putFirst(last), Messages{ "unused/0: its number of vertices differs from the metadata" });
  const std::vector<std::uint8_t> piece =
    *this->Open()->Read(BlobOfPiece(this->Open()->PieceIds().back(), this->Open()->Info().depths));
  ASSERT_EQ(putFirst(piece).size(), 1U);
  EXPECT_EQ(putFirst(piece).front().rfind("unused/0: ", 0), 0U);
  // An array that the model does not have.
  Piece other = *this->Open()->ReadUnused(0);
  other.attributes.push_back(
    { { "more", AttributeType::UInt8, AttributeAssociation::Point, 1 }, {} });
  other.attributes[0].values.resize(other.positions.size());
  EXPECT_EQ(putFirst(EncodePiece(other, UnusedCodec(ScalarType::Float64))),
    Messages{ "unused/0: its attributes differ from the metadata" });
}

// No memory is allocated for vertices that are only claimed.
TEST_F(StoreUnused, MoreThanTheFileHoldsAreRefused)
{
  this->Build(WithStrays(Survey(), RandomPoints(20, 5)), Options());
  for (const std::uint64_t claimed : { std::uint64_t{ 1 } << 53, std::uint64_t{ 1 } << 30 })
  {
    ModelDescription info = this->Open()->Info();
    info.unused->vertices = claimed;
    const std::vector<std::string> damage =
      this->DamageOf([&] { Sql(this->File(), PutMetadata(WriteStoredModel(info))); });
    ASSERT_EQ(damage.size(), 1U);
    EXPECT_NE(damage[0].find("is too small for " + std::to_string(claimed) + " unused vertices"),
      std::string::npos)
      << damage[0];
  }
}
