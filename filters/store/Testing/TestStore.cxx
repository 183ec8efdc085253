// SPDX-License-Identifier: BSD-3-Clause
// Builder and Store: what is written can be read back, and errors are reported.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/Weld.h"
#include "filters/core/pieces/Glue.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <set>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

BuildOptions Lossless(bool weld, std::uint32_t size = 200)
{
  BuildOptions options;
  options.tree.verticesPerPartition = size;
  options.bits = 0;
  options.weld = weld;
  return options;
}

Mesh GlueAll(const Store& store)
{
  std::vector<Piece> pieces;
  for (const PieceId id : store.PieceIds())
  {
    if (id.resolution.IsOriginal())
    {
      Result<Piece> piece = store.ReadPiece(id);
      EXPECT_TRUE(piece) << piece.GetError().message;
      pieces.push_back(std::move(*piece));
    }
  }
  Mesh mesh = *GluePartitions(pieces, store.Info().grid.scalarType);
  EXPECT_TRUE(AddUnused(store, mesh));
  return mesh;
}

}

TEST_F(StoreTest, LosslessWithoutWeldingGivesTheInputBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const BuildReport report = this->Build(named.mesh, Lossless(false));
    const auto store = *Store::Open(this->File());
    const Mesh all = GlueAll(*store);
    EXPECT_EQ(PointMultiset(all), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(all), TriangleMultiset(named.mesh));
    EXPECT_LE(report.info.largestPartition - report.info.smallestPartition, 1U);
    EXPECT_TRUE(store->Verify().empty());
  }
}

TEST_F(StoreTest, WithWeldingTheWeldedMeshComesBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const BuildReport report = this->Build(named.mesh, Lossless(true));
    Mesh welded = named.mesh;
    EXPECT_EQ(report.info.welded, WeldVertices(welded));
    const Mesh all = GlueAll(**Store::Open(this->File()));
    EXPECT_EQ(PointMultiset(all), PointMultiset(welded));
    EXPECT_EQ(TriangleMultiset(all), TriangleMultiset(welded));
  }
}

TEST_F(StoreTest, TheDigestDependsOnlyOnInputAndOptions)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    BuildOptions options;
    options.tree.verticesPerPartition = 200;
    std::set<std::string> digests;
    for (const unsigned threads : { 1U, 2U, 8U, 2U })
    {
      digests.insert(this->Build(named.mesh, options, MakeTbbExecution(threads)).info.digest);
    }
    EXPECT_EQ(digests.size(), 1U);
  }
  const Mesh torus = Torus(60, 40);
  std::set<std::string> digests;
  for (unsigned i = 0; i < 7; ++i)
  {
    BuildOptions options;
    options.tree.verticesPerPartition = i == 1 ? 300 : 200;
    options.tree.cellVertices = i == 2 ? 1 : 8;
    options.levels.byComponents = i != 3;
    options.levels.representative = i == 4 ? Representative::Mean : Representative::Quadric;
    options.bits = i == 5 ? 0 : i == 6 ? 16 : 20;
    digests.insert(this->Build(torus, options).info.digest);
  }
  EXPECT_EQ(digests.size(), 7U) << "an option changes nothing";
  BuildOptions titled;
  titled.title = "A title";
  EXPECT_EQ(this->Build(torus, titled).info.digest, this->Build(torus, {}).info.digest)
    << "the title is no content";
}

TEST_F(StoreTest, WhatTheStoreSaysIsTrue)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  options.title = "T";
  options.credit = "C";
  options.license = "L";
  options.unit = "mm";
  const Mesh mesh = Torus(96, 48);
  this->Build(mesh, options);
  const auto store = *Store::Open(this->File());
  const ModelDescription& info = store->Info();
  EXPECT_EQ(info.title + info.credit + info.license + info.unit + info.input, "TCLmmmesh.ply");
  EXPECT_EQ(info.vertices, mesh.points.size());
  EXPECT_EQ(info.triangles, mesh.triangles.size());
  EXPECT_EQ(info.original.triangles, mesh.triangles.size());
  EXPECT_EQ(info.box, BoxOfPoints(mesh.points));
  std::map<Resolution, ResolutionDescription> found;
  for (const PieceId id : store->PieceIds())
  {
    const Piece piece = *store->ReadPiece(id);
    ResolutionDescription& resolution = found[id.resolution];
    ++resolution.pieces;
    resolution.vertices += piece.ownVertices;
    resolution.bytes += store->Read(BlobOfPiece(id, store->Info().depths))->size();
    EXPECT_TRUE(piece.geometricErrors.empty());
  }
  const auto boxes = store->ReadBoxes();
  ASSERT_TRUE(boxes);
  PieceTable pieces(info.depths, info.HasLevels());
  for (const NodeId page : TreePages(info.depths))
  {
    const auto decoded = DecodeTreePage(*store->Read(protocol::BlobId::TreePage(page)), page,
      RoundedBoxOf(*boxes, page), info.depths, info.HasLevels());
    ASSERT_TRUE(decoded);
    const std::vector<PieceId> ids = PiecesOfTreePage(page, info.depths, info.HasLevels());
    for (std::size_t i = 0; i < ids.size(); ++i)
    {
      pieces.At(ids[i]) = decoded->facts[i];
    }
  }
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    const ResolutionDescription &level = info.levels[depth],
                                &expected = found[Resolution::Level(depth)];
    EXPECT_EQ(level.pieces, expected.pieces);
    EXPECT_EQ(level.vertices, expected.vertices);
    EXPECT_EQ(level.bytes, expected.bytes);
    EXPECT_LE(level.geometricError99, level.geometricError);
    float largest = 0;
    std::uint64_t bytes = 0;
    for (const PieceId id : store->PieceIds())
    {
      if (id.resolution == Resolution::Level(depth))
      {
        const PieceFacts& piece = pieces.At(id);
        EXPECT_LE(piece.most99, piece.most);
        largest = std::max(largest, piece.most);
        bytes += piece.bytes;
      }
    }
    EXPECT_GE(bytes, level.bytes);
    EXPECT_LE(double(bytes), 1.125 * double(level.bytes));
    EXPECT_LE(double(largest), 1.0626 * level.geometricError); // rounded up
    EXPECT_EQ(level.spacing, depth == 0 ? 4096U : level.spacing);
    EXPECT_LE(level.spacing * info.grid.step / 2, level.geometricError99 / 4);
  }
  EXPECT_EQ((*boxes)[1], info.box);
}

TEST_F(StoreTest, ManyThreadsReadAtOnce)
{
  BuildOptions options;
  options.tree.verticesPerPartition = 200;
  this->Build(Torus(96, 48), options);
  const auto store = *Store::Open(this->File());
  std::atomic<unsigned> bad{ 0 };
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 8; ++t)
  {
    threads.emplace_back(
      [&]()
      {
        for (const PieceId id : store->PieceIds())
        {
          bad += !store->ReadPiece(id);
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(bad, 0U);
}

TEST_F(StoreTest, SaysWhatIsWrong)
{
  BuildOptions options;
  options.memory = std::uint64_t{ 1 } << 20;
  ASSERT_TRUE(WriteMesh(this->File("torus.ply"), Torus(96, 48)));
  const auto small = BuildStore(this->File("torus.ply"), this->File(), options);
  ASSERT_FALSE(small);
  EXPECT_EQ(small.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_NE(small.GetError().message.find("the limit is 1 MiB"), std::string::npos)
    << small.GetError().message;
  EXPECT_FALSE(fs::exists(this->File()));

  EXPECT_TRUE(FailsAt(BuildStore(Mesh{}, "x", this->File(), {}), ErrorCode::InvalidInput));
  const Mesh wide{ { { -1.7e308, 0, 0 }, { 1.7e308, 0, 0 } }, {}, ScalarType::Float64 };
  EXPECT_TRUE(FailsAt(BuildStore(wide, "x", this->File(), {}), ErrorCode::InvalidInput));
  const auto unwritable = BuildStore(Torus(9, 9), "x", this->Folder / "no" / "x.kds", {});
  EXPECT_EQ(unwritable.GetError().code, ErrorCode::InputOutput);
  EXPECT_EQ(Store::Open(this->File("absent.kds")).GetError().code, ErrorCode::NotFound);
  std::ofstream(this->File("text.kds"))
    << "this is no store, but long enough to be mistaken for one ...........";
  EXPECT_FALSE(Store::Open(this->File("text.kds")));
}

TEST_F(StoreTest, NamesWithOddCharactersWork)
{
  for (const char* name : { "a b.kds", "100%?x=1#.kds", "ümlaut.kds", "'quote\".kds" })
  {
    SCOPED_TRACE(name);
    ASSERT_TRUE(BuildStore(Torus(9, 9), "x", this->File(name), {}));
    const auto store = Store::Open(this->File(name));
    ASSERT_TRUE(store) << store.GetError().message;
    EXPECT_TRUE((*store)->Verify().empty());
  }
}

TEST_F(StoreTest, LevelsOfLosslessStoresHaveTheInputsType)
{
  const Mesh offset = DisplacedSphere(4, { 4e6 + 0.123, 5e6, 7 }, 0.5);
  Mesh asDoubles = offset;
  asDoubles.scalarType = ScalarType::Float64;
  this->Build(asDoubles, Lossless(true));
  const Mesh all = GlueAll(**Store::Open(this->File()));
  EXPECT_EQ(PointMultiset(all), PointMultiset(asDoubles))
    << "doubles far from the origin survive exactly";
  BuildOptions grid;
  this->Build(asDoubles, grid);
  const auto store = *Store::Open(this->File());
  const Mesh onGrid = GlueAll(*store);
  EXPECT_LT(store->Info().grid.step, 2e-6);
  const Box box = BoxOfPoints(onGrid.points), input = BoxOfPoints(asDoubles.points);
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(box.lo[k], input.lo[k], store->Info().grid.step);
    EXPECT_NEAR(box.hi[k], input.hi[k], store->Info().grid.step);
  }
}
