// SPDX-License-Identifier: BSD-3-Clause
// Numbering, cutting and gluing: VertexTree, PieceCutter, Glue.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/core/EdgeCount.h"
#include "filters/core/pieces/Glue.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

const KdTreeOptions optionSets[] = { { 300, {}, 8 }, { 20, {}, 4 }, { 2000, {}, 8 }, { 1, {}, 1 } };

template <class Check>
void ForAll(const Check& check)
{
  for (const NamedMesh& named : AllMeshes())
  {
    for (const KdTreeOptions& options : optionSets)
    {
      if (options.verticesPerPartition < 20 && named.mesh.points.size() > 2000)
      {
        continue; // thousands of partitions of one vertex test nothing new
      }
      SCOPED_TRACE(
        named.name + ", " + std::to_string(options.verticesPerPartition) + " a partition");
      check(*MakeModel(named.mesh, options));
      check(*MakeModel(named.mesh, options, {}, {}, 2)); // small pieces
    }
  }
}

std::vector<Piece> Originals(const Model& model)
{
  std::vector<Piece> pieces;
  for (const auto& [id, piece] : model.pieces)
  {
    if (id.resolution.IsOriginal())
    {
      pieces.push_back(piece);
    }
  }
  return pieces;
}

}

TEST(VertexTree, ClustersFromTheStitchDepthOnAreIntervalsOfOnePartition)
{
  ForAll(
    [](const Model& model)
    {
      const VertexTree& tree = model.vertexTree;
      std::vector<VertexId> sorted = tree.original;
      std::sort(sorted.begin(), sorted.end());
      for (VertexId v = 0; v < sorted.size(); ++v)
      {
        ASSERT_EQ(sorted[v], v);
      }
      // Compares the finest cluster of each vertex, from levels that are built again, with the
      // interval that contains the vertex.
      const auto partition = CellOfVertex(model.tree, tree.depths.partition);
      const auto buckets = BucketTriangles(model.mesh.triangles,
        std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
      const ClusterLevels levels = *BuildLevels(model.mesh, model.tree, buckets, LevelOptions{});
      std::vector<VertexId> cluster = levels.finest;
      for (unsigned d = tree.depths.finest; d >= tree.depths.stitch; --d)
      {
        std::map<VertexId, VertexId> placeOf; // cluster as built -> place in the numbered level
        for (VertexId numbered = 0; numbered < tree.original.size(); ++numbered)
        {
          const VertexId original = tree.original[numbered];
          ASSERT_EQ(tree.PartitionOf(numbered), partition[original]);
          const VertexId place = tree.ClusterAt(d, numbered);
          const auto entry = placeOf.try_emplace(cluster[original], place).first;
          ASSERT_EQ(entry->second, place) << "level " << d << ": cluster is no interval";
          ASSERT_EQ(tree.levels[d].positions[place], levels.levels[d].positions[cluster[original]]);
        }
        ASSERT_EQ(placeOf.size(), tree.levels[d].first.size());
        if (d == 0)
        {
          break;
        }
        for (VertexId& c : cluster)
        {
          c = levels.levels[d].parents[c];
        }
      }
    });
}

TEST(VertexTree, ClustersAreNumberedByPlace)
{
  // Clusters of level S are ordered by place inside a partition; children are ordered by place
  // inside a cluster of a level >= S.
  const auto model = MakeModel(Shuffled(DisplacedSphere(4), 2), { 100, {}, 4 });
  const VertexTree& tree = model->vertexTree;
  for (unsigned d = tree.depths.stitch; d <= tree.depths.finest; ++d)
  {
    const VertexTreeLevel& level = tree.levels[d];
    for (VertexId c = 1; c < level.first.size(); ++c)
    {
      if (tree.PartitionOf(level.first[c - 1]) == tree.PartitionOf(level.first[c]) &&
          (d == tree.depths.stitch || level.parents[c - 1] == level.parents[c]))
      {
        ASSERT_LT(level.positions[c - 1], level.positions[c]) << "level " << d << ", cluster " << c;
      }
    }
  }
}

TEST(PieceCutter, EveryPieceIsWellFormed)
{
  ForAll(
    [](const Model& model)
    {
      for (const auto& [id, piece] : model.pieces)
      {
        const Status status = CheckPiece(piece, model.tree.depths);
        ASSERT_TRUE(status) << status.GetError().message;
      }
    });
}

TEST(PieceCutter, PiecesCoverTheirResolution)
{
  ForAll(
    [](const Model& model)
    {
      std::map<Resolution, std::map<VertexKey, Vec3>> owned;
      std::map<Resolution, std::map<std::array<VertexKey, 3>, unsigned>> triangles;
      for (const auto& [id, piece] : model.pieces)
      {
        for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
        {
          ASSERT_TRUE(owned[id.resolution].try_emplace(piece.keys[v], piece.positions[v]).second);
        }
        for (const Triangle& t : piece.triangles)
        {
          // A triangle counts only in the piece that owns its lowest vertex.
          const std::array<VertexKey, 3> keys{ piece.keys[t[0]], piece.keys[t[1]],
            piece.keys[t[2]] };
          const VertexKey lowest = std::min({ keys[0], keys[1], keys[2] });
          const auto end = piece.keys.begin() + piece.ownVertices;
          if (std::binary_search(piece.keys.begin(), end, lowest))
          {
            ++triangles[id.resolution][std::min({ keys, std::array{ keys[1], keys[2], keys[0] },
              std::array{ keys[2], keys[0], keys[1] } })];
          }
        }
      }
      for (const auto& [id, piece] : model.pieces)
      {
        for (std::uint32_t v = piece.ownVertices; v < piece.VertexCount(); ++v)
        {
          ASSERT_EQ(owned[id.resolution].at(piece.keys[v]), piece.positions[v])
            << "ghost differs from its vertex";
        }
      }
      for (unsigned d = 0; d <= model.tree.depths.finest; ++d)
      {
        const auto resolution = Resolution::Level(d);
        ASSERT_EQ(owned[resolution].size(), model.vertexTree.levels[d].first.size());
        ASSERT_EQ(triangles[resolution].size(), model.vertexTree.levels[d].triangles.size());
      }
      std::size_t originals = 0;
      for (const auto& entry : triangles[Resolution::Original()])
      {
        originals += entry.second;
      }
      ASSERT_EQ(originals, model.mesh.triangles.size());
      ASSERT_EQ(owned[Resolution::Original()].size(), model.mesh.points.size());
    });
}

TEST(PieceCutter, APieceHasEveryTriangleOfItsVertices)
{
  ForAll(
    [](const Model& model)
    {
      // The number of triangles around a vertex must be the same in the mesh and in the piece that
      // owns the vertex.
      std::vector<unsigned> around(model.mesh.points.size(), 0);
      for (const Triangle& t : model.mesh.triangles)
      {
        for (const VertexId v : std::set<VertexId>(t.begin(), t.end()))
        {
          ++around[v];
        }
      }
      for (const Piece& piece : Originals(model))
      {
        std::vector<unsigned> found(piece.ownVertices, 0);
        for (const Triangle& t : piece.triangles)
        {
          for (const VertexId v : std::set<VertexId>(t.begin(), t.end()))
          {
            found[std::min(v, piece.ownVertices - 1)] += v < piece.ownVertices;
          }
        }
        for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
        {
          const VertexId numbered = model.vertexTree.partitionBegin[PartitionOfKey(piece.keys[v])] +
                                    IndexOfKey(piece.keys[v]);
          ASSERT_EQ(found[v], around[model.vertexTree.original[numbered]]);
        }
      }
    });
}

TEST(PieceCutter, AncestorsAndChildNodesFollowTheVertexTree)
{
  ForAll(
    [](const Model& model)
    {
      const VertexTree& tree = model.vertexTree;
      const TreeDepths& depths = tree.depths;
      const unsigned preview = PreviewLevel(depths);
      std::map<std::pair<unsigned, VertexId>, std::set<NodeId>> childNodes;
      for (unsigned d = 1; d <= depths.stitch; ++d)
      {
        for (VertexId cluster = 0; cluster < tree.levels[d].first.size(); ++cluster)
        {
          childNodes[{ d - 1, tree.levels[d].parents[cluster] }].insert(PieceOfPartition(
            Resolution::Level(d), tree.PartitionOf(tree.levels[d].first[cluster]), depths)
                                                                          .node);
        }
      }
      for (const auto& [id, piece] : model.pieces)
      {
        const bool fine = id.resolution > Resolution::Level(depths.stitch);
        const unsigned depth = fine ? depths.stitch : id.resolution.Depth();
        for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
        {
          const auto ancestors = piece.AncestorsOf(v, depths);
          const bool carries = v >= piece.ownVertices || !fine;
          ASSERT_EQ(ancestors.size(), carries && depth > preview ? depth - preview : 0);
          if (!ancestors.empty())
          {
            const auto numbered = [&] {
              return tree.partitionBegin[PartitionOfKey(piece.keys[v])] + IndexOfKey(piece.keys[v]);
            };
            VertexId cluster = id.resolution < Resolution::Level(depths.stitch)
                                 ? static_cast<VertexId>(piece.keys[v])
                                 : tree.ClusterAt(depths.stitch, numbered());
            for (unsigned d = depth; d-- > preview;)
            {
              cluster = tree.levels[d + 1].parents[cluster];
              ASSERT_EQ(ancestors[d - preview], cluster);
            }
          }
        }
        ASSERT_EQ(piece.childBegin.empty(), id.resolution < Resolution::Level(preview) ||
                                              id.resolution >= Resolution::Level(depths.stitch));
        for (std::uint32_t v = 0; !piece.childBegin.empty() && v < piece.ownVertices; ++v)
        {
          const std::set<NodeId> nodes(piece.childNodes.begin() + piece.childBegin[v],
            piece.childNodes.begin() + piece.childBegin[v + 1]);
          ASSERT_EQ(
            nodes, (childNodes[{ id.resolution.Depth(), static_cast<VertexId>(piece.keys[v]) }]));
        }
      }
    });
}

TEST(Glue, GivesTheOriginalBack)
{
  ForAll(
    [](const Model& model)
    {
      const auto glued = GluePartitions(Originals(model), model.mesh.scalarType);
      ASSERT_TRUE(glued);
      // Compares indices, not only coordinates: vertex numbers are those of the vertex tree.
      std::vector<Triangle> expected, found = glued->triangles;
      std::vector<VertexId> number(model.mesh.points.size());
      for (VertexId v = 0; v < number.size(); ++v)
      {
        number[model.vertexTree.original[v]] = v;
        ASSERT_EQ(
          BitsOf(glued->points[v]), BitsOf(model.mesh.points[model.vertexTree.original[v]]));
      }
      for (const Triangle& t : model.mesh.triangles)
      {
        expected.push_back(RotateLowestFirst({ number[t[0]], number[t[1]], number[t[2]] }));
      }
      for (Triangle& t : found)
      {
        t = RotateLowestFirst(t);
      }
      // Triangles come partition by partition, each from the lowest partition that has it.
      ASSERT_TRUE(std::is_sorted(glued->triangles.begin(), glued->triangles.end(),
        [&](const Triangle& a, const Triangle& b)
        {
          return model.vertexTree.PartitionOf(std::min({ a[0], a[1], a[2] })) <
                 model.vertexTree.PartitionOf(std::min({ b[0], b[1], b[2] }));
        }));
      std::sort(expected.begin(), expected.end());
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected);
      ASSERT_EQ(PointMultiset(*glued), PointMultiset(model.mesh));
      ASSERT_EQ(TriangleMultiset(*glued), TriangleMultiset(model.mesh));
    });
}

TEST(Glue, ARegionHasEachTriangleOnceAndItsGhosts)
{
  const auto model = MakeModel(Torus(60, 30), { 100, {}, 8 });
  std::vector<Piece> some;
  for (const Piece& piece : Originals(*model))
  {
    if (PartitionOfKey(piece.keys[0]) % 3 != 1)
    {
      some.push_back(piece);
    }
  }
  const auto glued = GluePartitions(some, ScalarType::Float32);
  ASSERT_TRUE(glued);
  const auto partition = CellOfVertex(model->tree, model->tree.depths.partition);
  std::size_t expected = 0;
  for (const Triangle& t : model->mesh.triangles)
  {
    expected += std::any_of(t.begin(), t.end(), [&](VertexId v) { return partition[v] % 3 != 1; });
  }
  EXPECT_EQ(glued->triangles.size(), expected);
  const auto all = TriangleMultiset(*glued), input = TriangleMultiset(model->mesh);
  EXPECT_TRUE(std::includes(input.begin(), input.end(), all.begin(), all.end()));
  EXPECT_TRUE(
    fixtures::FailsAt(GluePartitions(std::vector{ some[0], some[0] }, ScalarType::Float32),
      ErrorCode::InvalidArgument, "partition " + std::to_string(PartitionOfKey(some[0].keys[0]))));
}

TEST(CountInconsistentEdges, CountsEdgesThatDoNotCancel)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    EXPECT_EQ(CountInconsistentEdges(named.mesh.triangles, named.mesh.points.size()), 0U)
      << named.name;
  }
  Mesh flipped = Torus(20, 20);
  std::swap(flipped.triangles[5][0], flipped.triangles[5][1]);
  for (const unsigned threads : { 1U, 2U })
  {
    EXPECT_EQ(
      CountInconsistentEdges(flipped.triangles, flipped.points.size(), MakeTbbExecution(threads)),
      3U);
  }
  EXPECT_EQ(CountInconsistentEdges(GridPlate(10).triangles, 121), 0U)
    << "a boundary is not inconsistent";
  const std::vector<Triangle> fan{ { 0, 1, 2 }, { 0, 1, 3 }, { 1, 0, 4 } };
  EXPECT_EQ(CountInconsistentEdges(fan, 5), 1U) << "three triangles at an edge";
  EXPECT_EQ(CountInconsistentEdges(std::vector<Triangle>{ { 0, 0, 1 }, { 0, 1, 1 } }, 2), 0U);
}
