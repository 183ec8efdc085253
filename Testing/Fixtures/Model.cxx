// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Model.h"

#include "filters/core/pieces/LeafOrder.h"

#include <set>

namespace kdstream::fixtures
{

std::unique_ptr<Model> MakeModel(const Mesh& mesh, const KdTreeOptions& treeOptions,
  const LevelOptions& levelOptions, const Execution& execution)
{
  auto model = std::make_unique<Model>();
  model->mesh = mesh;
  model->tree = *BuildKdTree(mesh.points, treeOptions, execution);
  const std::vector<std::uint32_t> partition =
    CellOfVertex(model->tree, model->tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << model->tree.depths.partition, [&](VertexId v) { return partition[v]; });
  model->vertexTree =
    NumberVertices(model->tree, *BuildLevels(mesh, model->tree, buckets, levelOptions, execution));
  OrderLeaves(model->vertexTree, model->mesh.points);
  for (unsigned d = 0; d <= model->tree.depths.finest + 1; ++d)
  {
    const Resolution resolution =
      d > model->tree.depths.finest ? Resolution::Original() : Resolution::Level(d);
    const PieceCutter cutter(model->vertexTree, model->mesh, resolution);
    for (std::size_t i = 0; i < cutter.PieceCount(); ++i)
    {
      Piece piece = cutter.Cut(i);
      const PieceId id = piece.id;
      model->pieces.emplace(id, std::move(piece));
    }
  }
  return model;
}

std::vector<Surface::Source> CutOfVertices(const Model& model, const Cut& cut)
{
  const VertexTree& tree = model.vertexTree;
  const unsigned finest = tree.depths.finest;
  // Ranks of every vertex's ancestors at all levels.
  const std::size_t n = tree.original.size();
  std::vector<std::vector<VertexId>> at(finest + 1, std::vector<VertexId>(n));
  for (VertexId v = 0; v < n; ++v)
  {
    at[finest][v] = tree.ClusterAt(finest, v);
    for (unsigned d = finest; d-- > 0;)
    {
      at[d][v] = tree.levels[d + 1].parents[at[d + 1][v]];
    }
  }
  std::set<VertexId> split;
  if (cut.base < Resolution::Level(tree.depths.stitch))
  {
    for (VertexId v = 0; v < n; ++v)
    {
      if (cut.RefinedTo(tree.PartitionOf(v)))
      {
        split.insert(at[cut.base.Depth()][v]);
      }
    }
  }
  std::vector<Surface::Source> nodes(n);
  for (VertexId v = 0; v < n; ++v)
  {
    Resolution shown = cut.base;
    if (const auto refined = cut.RefinedTo(tree.PartitionOf(v)))
    {
      shown = *refined;
    }
    else if (!cut.base.IsOriginal() && split.contains(at[cut.base.Depth()][v]))
    {
      shown = Resolution::Level(tree.depths.stitch);
    }
    VertexKey key = 0;
    if (shown.IsOriginal())
    {
      key = tree.KeyOf(v);
    }
    else
    {
      const VertexId rank = at[shown.Depth()][v];
      key = shown.Depth() < tree.depths.stitch ? rank
                                               : tree.KeyOf(tree.levels[shown.Depth()].first[rank]);
    }
    nodes[v] = { shown, key };
  }
  return nodes;
}

}
