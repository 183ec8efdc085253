// SPDX-License-Identifier: BSD-3-Clause
// Attributes in a store: they come back bit for bit, and levels have the arrays that they should.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/BuildInput.h"
#include "filters/build/BuildMemory.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/Testing/StoreContent.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class StoreAttributes : public StoreTest
{
protected:
  std::shared_ptr<Store> Build(const Mesh& mesh, const BuildOptions& options)
  {
    this->StoreTest::Build(mesh, options);
    return *Store::Open(this->File());
  }
};

BuildOptions Options(std::uint8_t bits, bool weld)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 90;
  options.bits = bits;
  options.weld = weld;
  return options;
}

Mesh GlueAll(const Store& store)
{
  std::vector<std::uint32_t> partitions(store.Info().partitions);
  std::iota(partitions.begin(), partitions.end(), 0U);
  Result<Mesh> mesh = GlueStoreMesh(store, partitions);
  EXPECT_TRUE(mesh) << mesh.GetError().message;
  EXPECT_TRUE(!mesh || AddUnused(store, *mesh));
  return mesh ? *mesh : Mesh{};
}

// Calls `check` for the fixtures' meshes that are small enough for thousands of bytes a vertex.
template <class Check>
void ForAll(const Check& check)
{
  std::uint32_t seed = 0;
  for (const NamedMesh& named : AllMeshes())
  {
    if (named.mesh.points.size() <= 3000)
    {
      SCOPED_TRACE(named.name);
      check(WithAttributes(named.mesh, ++seed));
    }
  }
  ASSERT_GT(seed, 8U);
}

}

TEST_F(StoreAttributes, LosslessStoresGiveEveryArrayBack)
{
  ForAll(
    [this](const Mesh& mesh)
    {
      for (const bool weld : { false, true })
      {
        const auto store = this->Build(mesh, Options(0, weld));
        Mesh expected = mesh;
        const std::size_t welded = weld ? WeldVertices(expected) : 0;
        EXPECT_EQ(store->Info().welded, welded);
        EXPECT_EQ(store->Info().attributes, InfosOf(mesh.attributes));
        const Mesh all = GlueAll(*store);
        EXPECT_EQ(InfosOf(all.attributes), InfosOf(mesh.attributes));
        EXPECT_TRUE(ContentOf(all) == ContentOf(expected));
        EXPECT_TRUE(store->Verify().empty());
      }
    });
}

TEST_F(StoreAttributes, ArraysOfVerticesComeFirst)
{
  Mesh mesh = WithAttributes(Torus(40, 20), 3);
  const std::vector<AttributeInfo> inOrder = InfosOf(mesh.attributes);
  const std::vector<Attribute> sorted = mesh.attributes;
  const auto firstCell = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& a) { return a.association == AttributeAssociation::Cell; });
  std::rotate(mesh.attributes.begin(), firstCell, mesh.attributes.end());
  const auto store = this->Build(mesh, Options(0, false));
  EXPECT_EQ(store->Info().attributes, inOrder);
  EXPECT_TRUE(store->Verify().empty());
  mesh.attributes = sorted;
  EXPECT_TRUE(ContentOf(GlueAll(*store)) == ContentOf(mesh));
}

TEST_F(StoreAttributes, AGridMovesPointsAndNothingElse)
{
  const Mesh mesh = WithAttributes(Torus(40, 20), 3);
  const auto store = this->Build(mesh, Options(12, false));
  Mesh expected = mesh;
  for (Vec3& point : expected.points)
  {
    point = store->Info().grid.Snap(point);
  }
  EXPECT_TRUE(ContentOf(GlueAll(*store)) == ContentOf(expected));
}

TEST_F(StoreAttributes, AFileComesBackThroughTheStore)
{
  ForAll(
    [this](const Mesh& mesh)
    {
      ASSERT_TRUE(WriteMesh(this->File("in.ply"), mesh));
      const auto built = BuildStore(this->File("in.ply"), this->File(), Options(0, false));
      ASSERT_TRUE(built) << built.GetError().message;
      const auto store = *Store::Open(this->File());
      ASSERT_TRUE(WriteMesh(this->File("out.ply"), GlueAll(*store)));
      const auto reader = MeshReader::Open(this->File("out.ply"));
      ASSERT_TRUE(reader);
      const Result<Mesh> out = ReadMesh(**reader, {});
      ASSERT_TRUE(out);
      if (!mesh.triangles.empty()) // a PLY without faces cannot store their arrays
      {
        EXPECT_EQ(InfosOf(out->attributes), InfosOf(mesh.attributes));
      }
      EXPECT_TRUE(ContentOf(*out) == ContentOf(mesh));
    });
}

TEST_F(StoreAttributes, TheDigestIsTheSameWhateverTheThreads)
{
  const Mesh plain = Shuffled(DisplacedSphere(4), 1);
  const Mesh mesh = WithAttributes(plain, 5);
  for (const LevelMaker maker : { LevelMaker::Cluster, LevelMaker::Collapse })
  {
    std::set<std::string> digests;
    BuildOptions options = Options(20, true);
    options.levels.maker = maker;
    for (const unsigned threads : { 1U, 2U, 8U, 2U })
    {
      const auto report =
        BuildStore(mesh, "mesh.ply", this->File(), options, MakeTbbExecution(threads));
      ASSERT_TRUE(report) << report.GetError().message;
      digests.insert(report->info.digest);
    }
    EXPECT_EQ(digests.size(), 1U);
    digests.insert(BuildStore(plain, "mesh.ply", this->File(), options)->info.digest);
    Mesh other = mesh;
    other.attributes.back().values.back() ^= 1;
    digests.insert(BuildStore(other, "mesh.ply", this->File(), options)->info.digest);
    EXPECT_EQ(digests.size(), 3U) << "every byte counts";
  }
}

TEST_F(StoreAttributes, LevelsHaveNormalsAndColours)
{
  const auto store = this->Build(WithAttributes(Torus(60, 30), 2), Options(20, true));
  const auto level = DrawStoreMesh(*store, { store->Info().depths, Resolution::Level(7) });
  ASSERT_TRUE(level);
  const std::vector<AttributeInfo> expected = ArraysOfLevels(store->Info().attributes);
  EXPECT_GE(expected.size(), 2U);
  EXPECT_EQ(InfosOf(level->attributes), expected);
  // Drawn together with a piece of the original: only the arrays that both have.
  const PieceId partition{ Resolution::Original(), NodeOfPartition(1, store->Info().depths) };
  const auto mixed = DrawStorePieces(*store, Resolution::Level(7), std::array{ partition });
  ASSERT_TRUE(mixed);
  std::set<std::string> names;
  for (const Attribute& attribute : mixed->attributes)
  {
    names.insert(attribute.name);
  }
  EXPECT_EQ(names.size(), expected.size());
  for (const AttributeInfo& info : expected)
  {
    EXPECT_TRUE(names.contains(info.name));
  }
}

TEST_F(StoreAttributes, LevelsHaveNoNormalThatIsNotANumber)
{
  Mesh mesh = Torus(40, 20);
  Attribute normals{ { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 }, {} };
  normals.values.resize(mesh.points.size() * 12);
  for (std::size_t i = 0; i < mesh.points.size() * 3; ++i)
  {
    normals.Set(i / 3, i % 3,
      i % 7 == 0         ? std::numeric_limits<double>::quiet_NaN()
      : (i / 3) % 5 == 0 ? 0.0
                         : double(i % 11) - 5);
  }
  mesh.attributes.push_back(normals);
  const auto store = this->Build(mesh, Options(0, false));
  for (const PieceId id : store->PieceIds())
  {
    const Result<Piece> piece = store->ReadPiece(id);
    ASSERT_TRUE(piece);
    const Attribute& array = piece->attributes.at(0);
    for (std::size_t i = 0; !id.resolution.IsOriginal() && i < array.TupleCount(); ++i)
    {
      const double length = std::hypot(array.Get(i, 0), array.Get(i, 1), array.Get(i, 2));
      ASSERT_TRUE(length == 0 || std::abs(length - 1) < 1e-6) << length;
    }
  }
  EXPECT_TRUE(ContentOf(GlueAll(*store)) == ContentOf(mesh)) << "kept bit for bit in the original";
}

TEST_F(StoreAttributes, AsManyAndAsLongAsAllowed)
{
  Mesh mesh = Torus(20, 10);
  const auto add = [&mesh](const std::string& name)
  {
    Attribute attribute{ { name, AttributeType::UInt8, AttributeAssociation::Point, 1 }, {} };
    attribute.values.resize(mesh.points.size(), static_cast<std::uint8_t>(name.size()));
    mesh.attributes.push_back(std::move(attribute));
  };
  for (std::size_t i = 0; i < mostAttributes; ++i)
  {
    const std::string number = std::to_string(i);
    add(std::string(longestAttributeName - number.size(), 'n') + number);
  }
  const auto store = this->Build(mesh, Options(20, false));
  EXPECT_EQ(store->Info().attributes, InfosOf(mesh.attributes));
  EXPECT_EQ(GlueAll(*store).attributes.size(), mostAttributes);

  const auto problem = [&]()
  {
    const auto report = BuildStore(mesh, "m.ply", this->File("none.kds"), Options(20, true));
    EXPECT_FALSE(fs::exists(this->File("none.kds")));
    EXPECT_TRUE(report || report.GetError().code == ErrorCode::InvalidInput);
    return report ? "" : report.GetError().message;
  };
  add("one too many");
  EXPECT_EQ(problem(), "256 attributes; the maximum is 255");
  const auto problemOfName = [&](const std::string& name)
  {
    mesh.attributes.resize(1);
    add(name);
    return problem();
  };
  EXPECT_EQ(problemOfName(""), "attribute 1 has a name of 0 bytes");
  EXPECT_EQ(problemOfName(std::string(300, 'x')), "attribute 1 has a name of 300 bytes");
  EXPECT_EQ(problemOfName("caf\xE9"), "attribute 1 has a name that is not valid UTF-8");
  EXPECT_EQ(problemOfName("two\nlines"), "attribute 1 has a name that is not valid UTF-8");
  EXPECT_EQ(problemOfName(mesh.attributes[0].name), "attribute 1 has the name of attribute 0");
  mesh.attributes.resize(1);
  mesh.attributes[0].values.pop_back();
  EXPECT_NE(problem().find("has 199 bytes"), std::string::npos);
}

TEST_F(StoreAttributes, PiecesWithOtherArraysThanTheMetadataSaysAreDamaged)
{
  Mesh mesh = Torus(40, 20);
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  colors.values.resize(mesh.points.size() * 3, 7);
  mesh.attributes.push_back(colors);
  ModelDescription info = this->Build(mesh, Options(20, true))->Info();
  info.attributes[0].type = AttributeType::Int8;
  Sql(this->File(), PutMetadata(WriteStoredModel(info)));
  const auto store = Store::Open(this->File());
  ASSERT_TRUE(store) << store.GetError().message;
  const Result<Piece> piece = (*store)->ReadPiece({ Resolution::Level(0), 1 });
  ASSERT_FALSE(piece);
  EXPECT_TRUE(FailsAt(piece, ErrorCode::Damaged, "levels/0/1"));
  const std::vector<Error> damage = (*store)->Verify();
  EXPECT_EQ(damage.size(), (*store)->PieceIds().size());
  EXPECT_EQ(damage.at(0).message, piece.GetError().message);
}
