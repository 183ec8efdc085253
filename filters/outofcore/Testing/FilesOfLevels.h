// SPDX-License-Identifier: BSD-3-Clause
// A mesh taken through core in memory, and its tree and levels written as files, for tests of the
// later steps.
#pragma once

#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/levels/CollapseRound.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/pieces/LeafOrder.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/files/Tuples.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

namespace kdstream::testing
{

// A resolution cut in memory.
struct CutResolution
{
  Resolution resolution;
  std::vector<Piece> pieces;
  std::size_t triangles = 0;
};

// A mesh taken through core in memory.
struct InMemory
{
  LevelMaker maker = LevelMaker::Collapse;
  Mesh mesh;
  KdTree tree;
  ClusterLevels levels;
  std::vector<CutResolution> cut; // coarse to fine

  const TreeDepths& Depths() const { return this->tree.depths; }
};

inline InMemory BuildInMemory(const Mesh& mesh, const KdTreeOptions& options, LevelMaker maker)
{
  InMemory built;
  built.maker = maker;
  built.mesh = mesh;
  built.tree = *BuildKdTree(mesh.points, options);
  const unsigned partition = built.Depths().partition;
  const std::vector<std::uint32_t> partitions = CellOfVertex(built.tree, partition);
  const TriangleBuckets buckets = BucketTriangles(
    mesh.triangles, std::size_t{ 1 } << partition, [&](VertexId v) { return partitions[v]; });
  LevelOptions levelOptions;
  levelOptions.maker = maker;
  built.levels = *BuildLevels(mesh, built.tree, buckets, levelOptions);
  VertexTree numbered = NumberVertices(built.tree, built.levels);
  OrderLeaves(numbered, mesh.points);
  for (unsigned d = 0; d <= built.Depths().finest + 1; ++d)
  {
    const auto resolution =
      d > built.Depths().finest ? Resolution::Original() : Resolution::Level(d);
    const PieceCutter cutter(numbered, mesh, resolution);
    CutResolution& cut = built.cut.emplace_back();
    cut.resolution = resolution;
    cut.triangles = cutter.TriangleCount();
    for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
    {
      cut.pieces.push_back(cutter.Cut(i));
    }
  }
  return built;
}

// The depths of the blocks that the files are cut into.
struct Blocks
{
  unsigned ofMesh = 0;
  unsigned ofLevels = 0; // at most as deep as DeepestBlocks
  unsigned firstInFiles = 0;

  std::string Describe() const
  {
    return "blocks of depth " + std::to_string(this->ofMesh) + " and " +
           std::to_string(this->ofLevels) + ", files from level " +
           std::to_string(this->firstInFiles);
  }
};

// The maximum depth of the blocks of a level. Siblings must be in one block, unless their parents
// are in memory. Free collapses may put siblings anywhere, so then there is only one block.
inline unsigned DeepestBlocks(const InMemory& built, unsigned depth, unsigned firstInFiles)
{
  const TreeDepths& depths = built.Depths();
  const auto isFree = [&](unsigned d)
  {
    const bool isFinest = d == depths.finest;
    const std::size_t clusters =
      isFinest ? built.mesh.points.size() : built.levels.levels[d + 1].lowest.size();
    const std::size_t triangles =
      isFinest ? built.mesh.triangles.size() : built.levels.levels[d + 1].triangles.size();
    return built.maker == LevelMaker::Collapse && !CollapsesInParts(depths, d, clusters, triangles);
  };
  if (depth > depths.stitch)
  {
    return PieceDepth(Resolution::Level(depth), depths);
  }
  return depth == 0 || isFree(depth) || (depth > firstInFiles && isFree(depth - 1))
           ? 0
           : PieceDepth(Resolution::Level(depth - 1), depths);
}

// The same tree and levels in files.
struct InFiles
{
  SpillFolder folder = MakeSpillFolder();
  MeshBlocks mesh;
  ExternalLevels levels;

  InFiles(const InMemory& built, const Blocks& blocks)
  {
    this->WriteMesh(built, blocks.ofMesh);
    const TreeDepths& depths = built.Depths();
    this->levels.firstInFiles = blocks.firstInFiles;
    this->levels.files.resize(depths.finest + 1);
    this->levels.coarse.assign(
      built.levels.levels.begin(), built.levels.levels.begin() + blocks.firstInFiles);
    this->levels.attributes = ArraysOfLevels(this->mesh.attributes);
    std::vector<VertexId> finest;
    for (const VertexId v : built.tree.order)
    {
      finest.push_back(built.levels.finest[v]);
    }
    this->levels.clusterOfRank = Spilled(this->folder, finest);
    std::vector<VertexId> counts(built.levels.levels.back().lowest.size(), 0);
    for (const VertexId cluster : finest)
    {
      ++counts[cluster];
    }
    for (unsigned d = depths.finest + 1; d-- > blocks.firstInFiles;)
    {
      this->WriteLevel(
        built, d, std::min(blocks.ofLevels, DeepestBlocks(built, d, blocks.firstInFiles)), counts);
      const std::vector<VertexId>& parents = built.levels.levels[d].parents;
      std::vector<VertexId> above(d > 0 ? built.levels.levels[d - 1].lowest.size() : 0, 0);
      for (std::size_t cluster = 0; cluster < parents.size(); ++cluster)
      {
        above[parents[cluster]] += counts[cluster];
      }
      counts = std::move(above);
    }
  }

private:
  std::vector<std::byte> Interleaved(
    const std::vector<Attribute>& attributes, AttributeAssociation association, std::size_t count)
  {
    std::vector<const Attribute*> arrays;
    for (const Attribute& array : attributes)
    {
      if (array.association == association)
      {
        arrays.push_back(&array);
      }
    }
    return InterleaveTuples(arrays, count);
  }

  template <class Scalar>
  SpillFile Records(const InMemory& built)
  {
    std::vector<PointRecord<Scalar>> records;
    for (const VertexId v : built.tree.order)
    {
      const Vec3& p = built.mesh.points[v];
      records.push_back({ { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, v });
    }
    return Spilled(this->folder, records);
  }

  void WriteMesh(const InMemory& built, unsigned blockDepth)
  {
    const Mesh& input = built.mesh;
    this->mesh.depths = built.Depths();
    this->mesh.vertexCount = static_cast<std::uint32_t>(input.points.size());
    this->mesh.triangleCount = static_cast<std::uint32_t>(input.triangles.size());
    this->mesh.box = built.tree.boxes[1];
    this->mesh.blockDepth = blockDepth;
    this->mesh.scalarType = input.scalarType;
    this->mesh.floats = std::all_of(input.points.begin(), input.points.end(),
      [](const Vec3& p)
      { return std::all_of(p.begin(), p.end(), [](double x) { return double(float(x)) == x; }); });
    this->mesh.records =
      this->mesh.floats ? this->Records<float>(built) : this->Records<double>(built);
    for (const Attribute& array : input.attributes)
    {
      this->mesh.attributes.push_back(array.Info());
    }
    std::vector<Attribute> byRank;
    for (const Attribute& array : input.attributes)
    {
      Attribute& moved = byRank.emplace_back(Attribute{ array.Info(), {} });
      for (std::size_t i = 0;
           array.association == AttributeAssociation::Point && i < built.tree.order.size(); ++i)
      {
        moved.Append(array, built.tree.order[i]);
      }
    }
    if (!input.attributes.empty())
    {
      this->mesh.pointTuples = Spilled(
        this->folder, this->Interleaved(byRank, AttributeAssociation::Point, input.points.size()));
      this->mesh.cellTuples = Spilled(this->folder,
        this->Interleaved(input.attributes, AttributeAssociation::Cell, input.triangles.size()));
    }
    this->WriteTriangles(built, blockDepth);
  }

  void WriteTriangles(const InMemory& built, unsigned blockDepth)
  {
    std::vector<VertexId> rankOf(built.mesh.points.size());
    for (std::size_t rank = 0; rank < rankOf.size(); ++rank)
    {
      rankOf[built.tree.order[rank]] = static_cast<VertexId>(rank);
    }
    const CellOfRank cellOf(this->mesh.vertexCount, blockDepth);
    this->mesh.triangles = std::move(*RecordBuckets<NumberedTriangle>::Create(this->folder, "test",
      this->mesh.BlockCount(), 3 * built.mesh.triangles.size(), std::uint64_t{ 1 } << 20));
    // From last to first: blocks may hold the triangles in any order.
    for (std::size_t t = built.mesh.triangles.size(); t-- > 0;)
    {
      NumberedTriangle triangle{ {}, static_cast<std::uint32_t>(t) };
      std::array<std::size_t, 3> cells{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        triangle.corners[k] = rankOf[built.mesh.triangles[t][k]];
        cells[k] = cellOf(triangle.corners[k]);
      }
      std::sort(cells.begin(), cells.end());
      const auto end = std::unique(cells.begin(), cells.end());
      for (auto cell = cells.begin(); cell != end; ++cell)
      {
        EXPECT_TRUE(this->mesh.triangles->Add(*cell, triangle));
      }
    }
    EXPECT_TRUE(this->mesh.triangles->Finish());
  }

  void WriteLevel(
    const InMemory& built, unsigned depth, unsigned blockDepth, const std::vector<VertexId>& counts)
  {
    const ClusterLevel& level = built.levels.levels[depth];
    LevelFile& file = this->levels.files[depth];
    file.depth = depth;
    file.blockDepth = blockDepth;
    const std::vector<std::uint32_t> cell = CellOfVertex(built.tree, blockDepth);
    file.begin.assign(file.BlockCount() + 1, 0);
    std::vector<ClusterRecord> clusters;
    for (std::size_t i = 0; i < level.lowest.size(); ++i)
    {
      clusters.push_back(
        { level.positions[i], level.geometricErrors[i], level.lowest[i], counts[i] });
      ++file.begin[cell[level.lowest[i]] + 1];
    }
    std::partial_sum(file.begin.begin(), file.begin.end(), file.begin.begin());
    EXPECT_TRUE(std::is_sorted(level.lowest.begin(), level.lowest.end(),
      [&](VertexId a, VertexId b) { return cell[a] < cell[b]; }));
    file.clusters = Spilled(this->folder, clusters);
    if (depth > 0)
    {
      file.parents = Spilled(this->folder, level.parents);
    }
    if (!level.attributes.empty())
    {
      file.tuples = Spilled(this->folder,
        this->Interleaved(level.attributes, AttributeAssociation::Point, clusters.size()));
    }
    ImageWriter writer(this->folder, file);
    EXPECT_TRUE(writer.Begin(0));
    for (std::size_t block = 0; block < file.BlockCount(); ++block)
    {
      std::vector<Triangle> all = level.triangles;
      EXPECT_TRUE(writer.Add(all));
    }
  }
};

}
