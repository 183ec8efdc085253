// SPDX-License-Identifier: BSD-3-Clause
// Working block by block gives the same numbers, pieces and sums of attributes as working on the
// whole. Tests VertexNumbers, PieceCutter with a part, and AttributeSums.
#include "filters/core/Testing/WholeAndBlocks.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/tree/Clustering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// The lowest number of each cluster of each level: the levels 0 … S as a whole, finer ones block by
// block.
std::vector<std::vector<VertexId>> NumberClusters(const Whole& whole, unsigned depth)
{
  const TreeDepths& depths = whole.Depths();
  std::vector<VertexId> partitionBegin;
  for (std::uint64_t p = 0; p < std::uint64_t{ 1 } << depths.partition; ++p)
  {
    partitionBegin.push_back(
      static_cast<VertexId>(RangeOfCell(whole.mesh.points.size(), depths.partition, p).begin));
  }
  partitionBegin.push_back(static_cast<VertexId>(whole.mesh.points.size()));
  std::vector<ClusterParents> coarse;
  for (std::size_t d = 0; d <= depths.stitch; ++d)
  {
    coarse.push_back(whole.Links(d));
  }
  std::vector<std::vector<VertexId>> first =
    FirstOfCoarseClusters(coarse, whole.counts[depths.stitch], partitionBegin);
  for (std::size_t d = depths.stitch + 1; d <= depths.finest; ++d)
  {
    std::vector<VertexId>& all = first.emplace_back();
    for (std::uint32_t block = 0; block < std::uint32_t{ 1 } << depth; ++block)
    {
      const auto [begin, end] = whole.Own(d, depth, block);
      const auto [beginAbove, endAbove] = whole.Own(d - 1, depth, block);
      std::vector<VertexId> parents(whole.levels.levels[d].parents.begin() + begin,
        whole.levels.levels[d].parents.begin() + end);
      for (VertexId& parent : parents)
      {
        parent -= beginAbove;
      }
      const auto own = [from = begin, to = end](const auto& values)
      { return std::span(values).subspan(from, to - from); };
      const ClusterLevel& level = whole.levels.levels[d];
      const std::vector<VertexId> ofBlock =
        FirstOfChildren({ parents, own(level.lowest), own(level.positions) }, own(whole.counts[d]),
          std::span(first[d - 1]).subspan(beginAbove, endAbove - beginAbove), MakeTbbExecution(2));
      all.insert(all.end(), ofBlock.begin(), ofBlock.end());
    }
  }
  return first;
}

// All original vertices in the order of their numbers, block by block.
std::vector<VertexId> NumberOriginals(
  const Whole& whole, unsigned depth, const std::vector<VertexId>& firstOfFinest)
{
  const std::size_t finest = whole.Depths().finest;
  std::vector<VertexId> all;
  for (std::uint32_t block = 0; block < std::uint32_t{ 1 } << depth; ++block)
  {
    const AtHand at = OriginalsOf(whole, depth, block);
    const auto [begin, end] = whole.Own(finest, depth, block);
    std::vector<VertexId> clusterOf = at.Take(whole.levels.finest);
    for (VertexId& cluster : clusterOf)
    {
      cluster = cluster >= begin && cluster < end ? cluster - begin : noVertex;
    }
    for (const VertexId v :
      OrderVertices(clusterOf, std::span(firstOfFinest).subspan(begin, end - begin),
        static_cast<VertexId>(all.size()), at.Take(whole.mesh.points), MakeTbbExecution(2)))
    {
      all.push_back(at.vertices[v]);
    }
  }
  return all;
}

// Numbers by their definition: vertices are ordered by partition; then, level by level from S on,
// by their cluster's place and lowest vertex; then by their own place; then by id.
std::vector<VertexId> OrderOfVertices(const Whole& whole)
{
  std::vector<VertexId> order(whole.mesh.points.size());
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  std::sort(order.begin(), order.end(),
    [&](VertexId a, VertexId b)
    {
      if (whole.partition[a] != whole.partition[b])
      {
        return whole.partition[a] < whole.partition[b];
      }
      for (std::size_t d = whole.Depths().stitch; d < whole.levels.levels.size(); ++d)
      {
        const ClusterLevel& level = whole.levels.levels[d];
        const VertexId inA = whole.ancestors[d][a], inB = whole.ancestors[d][b];
        if (inA != inB)
        {
          return level.positions[inA] != level.positions[inB]
                   ? level.positions[inA] < level.positions[inB]
                   : level.lowest[inA] < level.lowest[inB];
        }
      }
      return whole.mesh.points[a] != whole.mesh.points[b]
               ? whole.mesh.points[a] < whole.mesh.points[b]
               : a < b;
    });
  return order;
}

void ExpectEqual(const VertexTreeLevel& a, const VertexTreeLevel& b)
{
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.parents, b.parents);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.geometricErrors, b.geometricErrors);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.attributes, b.attributes);
}

void ExpectEqual(const Piece& a, const Piece& b)
{
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.primitive, b.primitive);
  EXPECT_EQ(a.ownVertices, b.ownVertices);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.keys, b.keys);
  EXPECT_EQ(a.geometricErrors, b.geometricErrors);
  EXPECT_EQ(a.ancestors, b.ancestors);
  EXPECT_EQ(a.childBegin, b.childBegin);
  EXPECT_EQ(a.childNodes, b.childNodes);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.attributes, b.attributes);
}

// The data of a level 0 … S that are needed to cut other resolutions.
VertexTreeLevel LinksOf(const VertexTreeLevel& level)
{
  return { level.first, level.parents, {}, {}, {} };
}

// The number of a piece's triangles whose vertex with the lowest key is an own vertex.
std::size_t LowestIsOwn(const Piece& piece)
{
  return static_cast<std::size_t>(std::count_if(piece.triangles.begin(), piece.triangles.end(),
    [&](const Triangle& t)
    {
      return *std::min_element(t.begin(), t.end(),
               [&](VertexId a, VertexId b)
               { return piece.keys[a] < piece.keys[b]; }) < piece.ownVertices;
    }));
}

// The levels 0 … S.
VertexTree CoarseTree(const Whole& whole, const std::vector<std::vector<VertexId>>& first)
{
  VertexTree tree;
  tree.depths = whole.Depths();
  tree.partitionBegin = whole.numbered.partitionBegin;
  tree.levels.resize(whole.levels.levels.size());
  std::vector<VertexId> places;
  for (std::size_t d = 0; d <= tree.depths.stitch; ++d)
  {
    OrderedLevel ordered = OrderLevel(whole.levels.levels[d], first[d], places);
    tree.levels[d] = std::move(ordered.level);
    places = std::move(ordered.places);
  }
  return tree;
}

// The part of a level finer than S that a block has.
VertexTreeLevel PartOfLevel(const Whole& whole, std::size_t d, unsigned depth, std::uint32_t block,
  std::span<const VertexId> first)
{
  const ClusterLevel& level = whole.levels.levels[d];
  const auto [begin, end] = whole.Own(d, depth, block);
  const AtHand at(level.lowest.size(), level.triangles,
    [from = begin, to = end](VertexId cluster) { return cluster >= from && cluster < to; });
  ClusterLevel part;
  part.positions = at.Take(level.positions);
  part.geometricErrors = at.Take(level.geometricErrors);
  part.lowest = at.Take(level.lowest);
  part.parents = at.Take(level.parents);
  part.triangles = at.Take(std::span<const Triangle>(level.triangles));
  part.attributes = at.Take(level.attributes);
  std::vector<VertexId> firstAtHand;
  for (const VertexId cluster : at.vertices)
  {
    firstAtHand.push_back(first[cluster]);
  }
  return OrderLevel(std::move(part), firstAtHand, {}).level;
}

// Cuts the pieces of one block of a resolution, all at once and each separately, and adds up the
// counts.
struct BlockCheck
{
  const std::vector<Piece>& expected; // of the whole
  PrimitiveType primitive;
  std::size_t triangles = 0, vertices = 0, blocks = 0;

  void Add(const VertexTree& tree, const Mesh& mesh, Resolution resolution, unsigned depth,
    std::uint32_t block)
  {
    const ModelPart all = PartOfCell(resolution, tree.depths, depth, block, this->primitive);
    const PieceCutter cutter(tree, mesh, resolution, MakeTbbExecution(2), all);
    ASSERT_EQ(cutter.PieceCount(), all.pieceCount);
    std::size_t ofPieces = 0;
    for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
    {
      ExpectEqual(cutter.Cut(i), this->expected[all.firstPiece + i]);
      const PieceCutter alone(
        tree, mesh, resolution, {}, ModelPart{ all.firstPiece + i, 1, this->primitive });
      ASSERT_EQ(alone.PieceCount(), 1U);
      ExpectEqual(alone.Cut(0), this->expected[all.firstPiece + i]);
      EXPECT_EQ(alone.TriangleCount(), LowestIsOwn(this->expected[all.firstPiece + i]));
      ofPieces += alone.TriangleCount();
    }
    EXPECT_EQ(cutter.TriangleCount(), ofPieces);
    this->triangles += cutter.TriangleCount();
    this->vertices += cutter.VertexCount();
    ++this->blocks;
  }
};

}

TEST(Blocks, NumbersFollowFromCounts)
{
  ForAllBlockMeshes(
    [](const Whole& whole)
    {
      const std::vector<VertexId> order = OrderOfVertices(whole);
      ASSERT_EQ(whole.numbered.original, order);
      for (const unsigned depth : BlockDepths(whole))
      {
        SCOPED_TRACE("blocks of depth " + std::to_string(depth));
        const std::vector<std::vector<VertexId>> first = NumberClusters(whole, depth);
        for (std::size_t d = 0; d < first.size(); ++d)
        {
          std::vector<VertexId> lowest(first[d].size(), noVertex);
          for (VertexId i = 0; i < order.size(); ++i)
          {
            VertexId& ofCluster = lowest[whole.ancestors[d][order[i]]];
            ofCluster = std::min(ofCluster, i);
          }
          ASSERT_EQ(first[d], lowest) << "level " << d;
        }
        ASSERT_EQ(NumberOriginals(whole, depth, first.back()), order);
      }
    });
}

TEST(Blocks, PiecesAreThoseOfTheWhole)
{
  std::size_t parts = 0; // parts of levels finer than S that have several pieces
  ForAllBlockMeshes(
    [&](const Whole& whole)
    {
      const TreeDepths& depths = whole.Depths();
      const std::vector<std::vector<VertexId>> first = NumberClusters(whole, depths.partition);
      VertexTree tree = CoarseTree(whole, first);
      for (std::size_t d = 0; d <= depths.stitch; ++d)
      {
        ExpectEqual(tree.levels[d], whole.numbered.levels[d]);
        tree.levels[d] = LinksOf(whole.numbered.levels[d]);
      }
      const auto primitive =
        whole.mesh.triangles.empty() ? PrimitiveType::Points : PrimitiveType::Triangles;
      for (unsigned d = 0; d <= depths.finest + 1; ++d)
      {
        const auto resolution = d > depths.finest ? Resolution::Original() : Resolution::Level(d);
        SCOPED_TRACE(resolution.IsOriginal() ? "original" : "level " + std::to_string(d));
        const PieceCutter cutter(whole.numbered, whole.mesh, resolution);
        std::vector<Piece> expected;
        for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
        {
          expected.push_back(cutter.Cut(i));
        }
        for (const unsigned depth : BlockDepths(whole))
        {
          if (depth > PieceDepth(resolution, depths))
          {
            continue;
          }
          BlockCheck check{ expected, primitive };
          for (std::uint32_t block = 0; block < std::uint32_t{ 1 } << depth; ++block)
          {
            if (resolution.IsOriginal())
            {
              const AtHand at = OriginalsOf(whole, depth, block);
              NumberPart(tree, at.Take(whole.numberOf));
              check.Add(tree, MeshOf(whole, at), resolution, depth, block);
            }
            else if (d > depths.stitch)
            {
              tree.levels[d] = PartOfLevel(whole, d, depth, block, first[d]);
              check.Add(tree, Mesh{}, resolution, depth, block);
              tree.levels[d] = {};
              parts += depth > 0;
            }
            else
            {
              tree.levels[d] = whole.numbered.levels[d];
              check.Add(tree, Mesh{}, resolution, depth, block);
              tree.levels[d] = LinksOf(whole.numbered.levels[d]);
            }
            if (::testing::Test::HasFailure())
            {
              return; // one failure is enough
            }
          }
          EXPECT_EQ(check.triangles, cutter.TriangleCount());
          EXPECT_EQ(check.vertices, cutter.VertexCount());
        }
        tree.numbers.clear();
        tree.original.clear();
      }
      ASSERT_EQ(PieceCutter(whole.numbered, whole.mesh, Resolution::Original()).TriangleCount(),
        whole.mesh.triangles.size());
    });
  EXPECT_GT(parts, 100U);
}

TEST(Blocks, PartitionsOfATreeWithoutLevelsAreThoseOfTheWhole)
{
  const Mesh mesh = WithColors(Torus(20, 10), 4);
  Clustering clustering{ {}, 5 };
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
  {
    clustering.clusterOf.push_back(v / 7 % 5);
  }
  const KdTree kdTree = TreeOfClustering(mesh.points, clustering);
  Whole whole{ mesh, kdTree, {}, NumberVertices(kdTree, {}), clustering.clusterOf, {}, {}, {} };
  whole.numberOf.resize(mesh.points.size());
  for (VertexId i = 0; i < whole.numberOf.size(); ++i)
  {
    whole.numberOf[whole.numbered.original[i]] = i;
  }
  const PieceCutter cutter(whole.numbered, mesh, Resolution::Original());
  VertexTree tree;
  tree.depths = whole.Depths();
  tree.partitionBegin = whole.numbered.partitionBegin;
  for (std::uint32_t p = 0; p < 8; ++p) // the last three are empty
  {
    const AtHand at = OriginalsOf(whole, tree.depths.partition, p);
    const Mesh part = MeshOf(whole, at);
    NumberPart(tree, at.Take(whole.numberOf));
    const PieceCutter ofPart(
      tree, part, Resolution::Original(), {}, ModelPart{ p, 1, PrimitiveType::Triangles });
    ExpectEqual(ofPart.Cut(0), cutter.Cut(p));
    EXPECT_EQ(ofPart.VertexCount() == 0, p >= 5);
  }
}

TEST(Blocks, SumsOfAttributesAreThoseOfTheWhole)
{
  std::size_t compared = 0;
  ForAllBlockMeshes(
    [&](const Whole& whole)
    {
      if (whole.mesh.attributes.empty())
      {
        return;
      }
      const TreeDepths& depths = whole.Depths();
      const std::vector<ClusterLevel>& levels = whole.levels.levels;
      const std::vector<AttributeInfo> infos(
        whole.mesh.attributes.begin(), whole.mesh.attributes.end());
      AttributeSums sums(infos, levels.back().lowest.size());
      sums.AddVertices(whole.mesh.attributes, whole.levels.finest);
      std::vector<std::vector<std::byte>> expected(levels.size());
      for (std::size_t d = levels.size(); d-- > 0;)
      {
        std::vector<Attribute> means = sums.Means();
        ASSERT_EQ(means.size(), levels[d].attributes.size());
        for (std::size_t i = 0; i < means.size(); ++i)
        {
          // Levels by collapse get new colours (TestCollapseAttributes).
          const bool isColors = RoleOf(means[i]) == AttributeRole::Colors && d + 1 < levels.size();
          EXPECT_TRUE(isColors || means[i] == levels[d].attributes[i]) << means[i].name;
        }
        expected[d].assign(sums.Bytes().begin(), sums.Bytes().end());
        ASSERT_EQ(expected[d].size(), sums.RecordSize() * levels[d].lowest.size());
        if (d > 0)
        {
          sums = sums.MakeCoarser(levels[d].parents, levels[d].lowest, levels[d - 1].lowest.size());
        }
      }
      for (const unsigned depth : BlockDepths(whole))
      {
        std::vector<std::vector<std::byte>> joined(levels.size());
        for (std::uint32_t block = 0; block < std::uint32_t{ 1 } << depth; ++block)
        {
          const AtHand at = OriginalsOf(whole, depth, block);
          auto [begin, end] = whole.Own(depths.finest, depth, block);
          std::vector<VertexId> clusterOf = at.Take(whole.levels.finest);
          for (VertexId& cluster : clusterOf)
          {
            cluster = cluster >= begin && cluster < end ? cluster - begin : noVertex;
          }
          AttributeSums ofBlock(infos, end - begin);
          ofBlock.AddVertices(at.Take(whole.mesh.attributes), clusterOf);
          for (std::size_t d = depths.finest;; --d)
          {
            const std::span<const std::byte> bytes = ofBlock.Bytes();
            joined[d].insert(joined[d].end(), bytes.begin(), bytes.end());
            const auto loaded =
              AttributeSums::FromBytes(infos, std::vector<std::byte>(bytes.begin(), bytes.end()));
            ASSERT_TRUE(loaded) << loaded.GetError().message;
            if (d == depths.stitch)
            {
              break;
            }
            const auto [beginAbove, endAbove] = whole.Own(d - 1, depth, block);
            std::vector<VertexId> parents(
              levels[d].parents.begin() + begin, levels[d].parents.begin() + end);
            for (VertexId& parent : parents)
            {
              parent -= beginAbove;
            }
            ofBlock = loaded->MakeCoarser(parents,
              std::span(levels[d].lowest).subspan(begin, end - begin), endAbove - beginAbove);
            begin = beginAbove;
            end = endAbove;
          }
        }
        for (std::size_t d = depths.stitch; d <= depths.finest; ++d)
        {
          ASSERT_EQ(joined[d], expected[d]) << "level " << d;
          ++compared;
        }
      }
    });
  EXPECT_GT(compared, 300U);
}
