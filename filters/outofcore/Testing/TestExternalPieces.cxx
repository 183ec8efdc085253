// SPDX-License-Identifier: BSD-3-Clause
// Pieces cut out of core, part by part, are compared with pieces cut in memory: ExternalNumbers,
// ExternalPieces. The levels are made in memory and written as files, so that only the numbers and
// the parts can differ.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/outofcore/Testing/FilesOfLevels.h"
#include "filters/outofcore/pieces/ExternalPieces.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

std::vector<std::uint64_t> Bits(const std::vector<Vec3>& points)
{
  std::vector<std::uint64_t> bits;
  for (const Vec3& p : points)
  {
    const PointBits of = BitsOf(p);
    bits.insert(bits.end(), of.begin(), of.end());
  }
  return bits;
}

void ExpectEqual(const Piece& a, const Piece& b)
{
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(a.ownVertices, b.ownVertices);
  EXPECT_EQ(Bits(a.positions), Bits(b.positions));
  EXPECT_EQ(a.keys, b.keys);
  EXPECT_EQ(a.geometricErrors, b.geometricErrors);
  EXPECT_EQ(a.ancestors, b.ancestors);
  EXPECT_EQ(a.childBegin, b.childBegin);
  EXPECT_EQ(a.childNodes, b.childNodes);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.attributes, b.attributes);
}

const Error enough{ ErrorCode::NotFound, "one difference is enough to read" };

// Cuts each part that it is given, and compares the pieces.
class PartCheck
{
public:
  PartCheck(const InMemory& built, const InFiles& files, const Execution& execution)
    : Expected(built)
    , Files(files)
    , Exec(execution)
  {
  }

  Status Add(const VertexTree& tree, const Mesh& mesh, Resolution resolution, const ModelPart& part)
  {
    if (this->At == this->Expected.cut.size())
    {
      ADD_FAILURE() << "a part too many";
      return enough;
    }
    const CutResolution& expected = this->Expected.cut[this->At];
    SCOPED_TRACE(
      resolution.IsOriginal() ? "original" : "level " + std::to_string(resolution.Depth()));
    EXPECT_EQ(resolution, expected.resolution);
    EXPECT_EQ(part.firstPiece, this->NextPiece);
    if (::testing::Test::HasFailure() || part.pieceCount > expected.pieces.size() - this->NextPiece)
    {
      ADD_FAILURE() << "pieces " << part.firstPiece << " + " << part.pieceCount;
      return enough;
    }
    this->CheckSize(tree, mesh, resolution);
    const PieceCutter cutter(tree, mesh, resolution, this->Exec, part);
    EXPECT_EQ(cutter.PieceCount(), part.pieceCount);
    for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
    {
      ExpectEqual(cutter.Cut(i), expected.pieces[this->NextPiece++]);
      if (::testing::Test::HasFailure())
      {
        return enough;
      }
    }
    this->Triangles += cutter.TriangleCount();
    ++this->Parts;
    if (this->NextPiece == expected.pieces.size())
    {
      EXPECT_EQ(this->Triangles, expected.triangles);
      EXPECT_EQ(this->Parts, this->PartsOf(resolution));
      this->NextPiece = this->Triangles = this->Parts = 0;
      ++this->At;
    }
    return {};
  }

  void Finish() const { EXPECT_EQ(this->At, this->Expected.cut.size()); }

private:
  std::size_t PartsOf(Resolution resolution) const
  {
    if (resolution.IsOriginal())
    {
      return this->Files.mesh.BlockCount();
    }
    const unsigned d = resolution.Depth();
    return d >= this->Files.levels.firstInFiles ? this->Files.levels.files[d].BlockCount() : 1;
  }

  // A part must not hold more than ExternalPieces promises.
  void CheckSize(const VertexTree& tree, const Mesh& mesh, Resolution resolution) const
  {
    const std::size_t atHand =
      resolution.IsOriginal() ? mesh.points.size() : tree.levels[resolution.Depth()].first.size();
    for (unsigned d = 0; d < tree.levels.size(); ++d)
    {
      if (resolution != Resolution::Level(d))
      {
        const VertexTreeLevel& level = tree.levels[d];
        EXPECT_EQ(level.positions.capacity() + level.geometricErrors.capacity() +
                    level.triangles.capacity() + level.attributes.capacity(),
          0U);
        if (d < this->Files.levels.firstInFiles)
        {
          EXPECT_EQ(level.first.size(), this->Expected.levels.levels[d].lowest.size());
          continue;
        }
        const bool above = d >= PreviewLevel(tree.depths) && d <= tree.depths.stitch &&
                           resolution > Resolution::Level(d);
        EXPECT_LE(level.parents.size(), above ? atHand : 0U);
        const bool holds =
          d == tree.depths.stitch && resolution > Resolution::Level(tree.depths.stitch);
        EXPECT_LE(level.first.size(), holds ? atHand : 0U);
        EXPECT_TRUE(level.childNodes.empty());
      }
    }
    EXPECT_EQ(tree.original.size(), mesh.points.size());
    EXPECT_TRUE(resolution.IsOriginal() || mesh.points.empty());
    EXPECT_EQ(mesh.scalarType,
      resolution.IsOriginal() ? this->Expected.mesh.scalarType : ScalarType::Float32);
  }

  const InMemory& Expected;
  const InFiles& Files;
  const Execution& Exec;
  std::size_t At = 0, NextPiece = 0, Triangles = 0, Parts = 0;
};

void Check(const InMemory& built, const Blocks& blocks, const Execution& execution)
{
  SCOPED_TRACE(blocks.Describe());
  InFiles files(built, blocks);
  const Result<ExternalNumbers> numbers =
    NumberExternally(files.folder, files.mesh, files.levels, execution);
  ASSERT_TRUE(numbers) << numbers.GetError().message;
  PartCheck check(built, files, execution);
  const Status status = ForEachPart(
    files.mesh, files.levels, *numbers,
    [&](const VertexTree& tree, const Mesh& mesh, Resolution resolution, const ModelPart& part)
    { return check.Add(tree, mesh, resolution, part); },
    execution);
  ASSERT_TRUE(status) << status.GetError().message;
  check.Finish();
}

// With few vertices a cell there are levels finer than S, some of them in several pieces.
const KdTreeOptions optionSets[] = { { 300, {}, 8 }, { 20, {}, 4 }, { 2000, {}, 8 }, { 1, {}, 1 },
  { 300, {}, 1 }, { 3000, {}, 2 } };

std::vector<NamedMesh> Meshes()
{
  std::vector<NamedMesh> meshes = ClosedMeshes();
  for (NamedMesh& hard : HardMeshes())
  {
    meshes.push_back({ hard.name + " with arrays", WithAttributes(std::move(hard.mesh), 3) });
  }
  meshes.push_back({ "torus with arrays", WithAttributes(Shuffled(Torus(90, 60), 4), 1) });
  return meshes;
}

}

TEST(ExternalPieces, AreThoseCutInMemory)
{
  std::mt19937 random(7);
  const auto upTo = [&](unsigned most) { return static_cast<unsigned>(random() % (most + 1)); };
  const Execution execution = MakeTbbExecution(2);
  std::size_t parts = 0; // of levels finer than S, in several blocks
  for (const NamedMesh& named : Meshes())
  {
    for (const KdTreeOptions& options : optionSets)
    {
      if (options.verticesPerPartition < 20 && named.mesh.points.size() > 2000)
      {
        continue; // thousands of partitions of one vertex test nothing new
      }
      for (const LevelMaker maker : { LevelMaker::Collapse, LevelMaker::Cluster })
      {
        SCOPED_TRACE(named.name + ", " + std::to_string(options.verticesPerPartition) +
                     " a partition, maker " + std::to_string(int(maker)));
        const InMemory built = BuildInMemory(named.mesh, options, maker);
        const TreeDepths& depths = built.Depths();
        // Files of thousands of blocks take long, and test nothing new.
        const unsigned deepest = std::min(depths.partition, 5U);
        Check(built,
          maker == LevelMaker::Collapse
            ? Blocks{ deepest, deepest, 0 }
            : Blocks{ upTo(deepest), upTo(deepest), upTo(depths.stitch) },
          execution);
        if (::testing::Test::HasFailure())
        {
          return;
        }
        for (unsigned d = depths.stitch + 1; d <= depths.finest; ++d)
        {
          parts += PieceDepth(Resolution::Level(d), depths) > 0;
        }
      }
    }
  }
  EXPECT_GT(parts, 20U);
}

// Deep trees: many partitions, levels finer than S in several blocks.
TEST(ExternalPieces, OfManyPartitions)
{
  const Execution execution = MakeTbbExecution(2);
  Mesh torus = WithAttributes(Shuffled(Torus(300, 210), 9), 5);
  std::size_t arrays = 0; // testing all arrays would take long
  std::erase_if(torus.attributes, [&](const Attribute& array)
    { return RoleOf(array) == AttributeRole::Other && ++arrays % 7 != 0; });
  ASSERT_GT(torus.attributes.size(), 3U);
  struct Deep
  {
    KdTreeOptions options;
    LevelMaker maker;
    TreeDepths depths;
    std::vector<Blocks> blocks;
  };
  const Deep cases[] = {
    { { 50, {}, 8 }, LevelMaker::Collapse, { 11, 13, 13 }, { { 3, 1, 5 }, { 6, 3, 13 } } },
    { { 300, {}, 8 }, LevelMaker::Collapse, { 8, 12, 13 }, { { 3, 1, 5 }, { 6, 3, 12 } } },
    { { 2000, {}, 4 }, LevelMaker::Collapse, { 5, 9, 14 }, { { 3, 1, 5 }, { 5, 3, 9 } } },
    { { 20, {}, 1 }, LevelMaker::Cluster, { 12, 16, 16 }, { { 5, 4, 13 } } },
  };
  for (const Deep& deep : cases)
  {
    const InMemory built = BuildInMemory(torus, deep.options, deep.maker);
    ASSERT_EQ(built.Depths(), deep.depths);
    for (const Blocks& blocks : deep.blocks)
    {
      Check(built, blocks, execution);
      if (::testing::Test::HasFailure())
      {
        return;
      }
    }
  }
}

// Levels coarser than S, from 16 on, that are collapsed in parts.
TEST(ExternalPieces, OfLevelsBelowTheStitchInBlocks)
{
  const InMemory built =
    BuildInMemory(Shuffled(Torus(600, 420), 2), { 20, {}, 1 }, LevelMaker::Collapse);
  ASSERT_EQ(built.Depths(), (TreeDepths{ 14, 18, 18 }));
  for (const Blocks& blocks : { Blocks{ 4, 6, 16 }, Blocks{ 2, 3, 17 }, Blocks{ 5, 5, 9 } })
  {
    Check(built, blocks, MakeTbbExecution(2));
  }
}

namespace
{

InMemory SmallModel()
{
  InMemory built = BuildInMemory(Torus(90, 60), { 300, {}, 1 }, LevelMaker::Collapse);
  EXPECT_EQ(built.Depths(), (TreeDepths{ 5, 9, 13 }));
  return built;
}

}

TEST(ExternalPieces, ReportBlocksAndStop)
{
  const InMemory built = SmallModel();
  InFiles files(built, { 3, 1, 5 });
  // One block in each of the levels 10 and 11, two in each of 12 and 13, and eight of the mesh.
  constexpr std::size_t blocks = 1 + 1 + 2 + 2 + 8;
  // Up to four blocks of a level are numbered at once, with one report.
  constexpr std::size_t reports = 1 + 1 + 1 + 1 + 2;
  for (std::size_t most = 1; most <= reports + 1; ++most)
  {
    std::vector<double> fractions;
    Execution execution;
    execution.progress = [&](std::string_view step, double fraction)
    {
      EXPECT_EQ(step, "levels");
      fractions.push_back(fraction);
      return fractions.size() < most;
    };
    const auto numbers = NumberExternally(files.folder, files.mesh, files.levels, execution);
    ASSERT_EQ(bool(numbers), most > reports);
    EXPECT_EQ(fractions.size(), std::min(most, reports));
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    if (!numbers)
    {
      EXPECT_EQ(numbers.GetError().code, ErrorCode::Cancelled);
      continue;
    }
    EXPECT_EQ(fractions.back(), 1.0);
    // Ten levels, each as one part; then the blocks.
    for (std::size_t last = 1; last <= 10 + blocks; ++last)
    {
      std::size_t visits = 0;
      const Status status = ForEachPart(files.mesh, files.levels, *numbers,
        [&](const VertexTree&, const Mesh&, Resolution, const ModelPart&) {
          return ++visits < last ? Status{} : Error{ ErrorCode::Cancelled, "enough" };
        });
      ASSERT_FALSE(status);
      EXPECT_EQ(status.GetError().message, "enough");
      EXPECT_EQ(visits, last);
    }
  }
}

TEST(ExternalPieces, RefuseFilesThatDoNotFitTogether)
{
  const InMemory built = SmallModel();
  const auto problem = [&](const std::function<void(InFiles&)>& damage)
  {
    InFiles files(built, { 2, 1, 3 });
    damage(files);
    const auto numbers = NumberExternally(files.folder, files.mesh, files.levels);
    if (numbers)
    {
      return std::string();
    }
    EXPECT_EQ(numbers.GetError().code, ErrorCode::Damaged);
    return numbers.GetError().message;
  };
  const auto put = [](SpillFile& file, std::uint64_t at, VertexId value)
  { EXPECT_TRUE(WriteRecords<VertexId>(file, at, std::span<const VertexId>(&value, 1))); };
  const auto countOf = [&](std::size_t d)
  { return std::to_string(built.levels.levels[d].lowest.size()); };

  EXPECT_EQ(problem([](InFiles&) {}), "");
  for (const unsigned d : { 3U, 9U, 10U, 13U })
  {
    EXPECT_EQ(problem([&](InFiles& files) { put(files.levels.files[d].parents, 5, noVertex - 1); }),
      "level " + std::to_string(d) + ": the parent of cluster 5 is 4294967294 of " +
        countOf(d - 1));
  }
  EXPECT_EQ(problem([&](InFiles& files) { put(files.levels.clusterOfRank, 9, noVertex); }),
    "level 13: vertices of cluster 4294967295 of " + countOf(13));
  // Assigns a vertex of another cluster of the same block to the first cluster.
  const VertexId cluster = built.levels.finest[built.tree.order[0]];
  const auto isOther = [&](VertexId v) { return built.levels.finest[v] != cluster; };
  const auto other = std::find_if(built.tree.order.begin(), built.tree.order.end(), isOther);
  const std::string wrong = problem(
    [&](InFiles& files)
    {
      put(files.levels.clusterOfRank, static_cast<std::uint64_t>(other - built.tree.order.begin()),
        cluster);
    });
  EXPECT_NE(wrong.find("has a wrong count of vertices"), std::string::npos) << wrong;
}

TEST(ExternalPieces, SayWhatCannotBeRead)
{
  const InMemory built = SmallModel();
  const std::vector<VertexId> few(3, 0);
  const auto codeOf = [&](const std::function<void(InFiles&, ExternalNumbers*)>& damage)
  {
    InFiles files(built, { 2, 1, 3 });
    damage(files, nullptr);
    Result<ExternalNumbers> numbers = NumberExternally(files.folder, files.mesh, files.levels);
    if (!numbers)
    {
      return numbers.GetError().code;
    }
    damage(files, &*numbers);
    const Status status = ForEachPart(files.mesh, files.levels, *numbers,
      [](const VertexTree&, const Mesh&, Resolution, const ModelPart&) { return Status{}; });
    return status ? ErrorCode::NotFound : status.GetError().code;
  };
  const auto shorten = [&](InFiles& files, SpillFile& file) { file = Spilled(files.folder, few); };
  using Member = SpillFile LevelFile::*;
  for (const Member member : { &LevelFile::clusters, &LevelFile::parents, &LevelFile::triangles })
  {
    for (const unsigned d : { 4U, 12U })
    {
      EXPECT_EQ(codeOf([&](InFiles& files, ExternalNumbers* numbers)
                  { numbers ? void() : shorten(files, files.levels.files[d].*member); }),
        ErrorCode::InputOutput);
    }
  }
  EXPECT_EQ(codeOf([&](InFiles& files, ExternalNumbers* numbers)
              { numbers ? void() : shorten(files, files.mesh.records); }),
    ErrorCode::InputOutput);
  EXPECT_EQ(codeOf([&](InFiles& files, ExternalNumbers* numbers)
              { numbers ? void() : shorten(files, files.levels.clusterOfRank); }),
    ErrorCode::InputOutput);
  EXPECT_EQ(codeOf([&](InFiles& files, ExternalNumbers* numbers)
              { numbers ? shorten(files, numbers->first[11]) : void(); }),
    ErrorCode::InputOutput);
  EXPECT_EQ(codeOf([&](InFiles& files, ExternalNumbers* numbers)
              { numbers ? shorten(files, numbers->numberOfRank) : void(); }),
    ErrorCode::InputOutput);
  EXPECT_EQ(codeOf([](InFiles&, ExternalNumbers*) {}), ErrorCode::NotFound) << "nothing is wrong";
}
