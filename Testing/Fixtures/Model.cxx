// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Model.h"

#include "filters/core/pieces/LeafOrder.h"

#include <algorithm>

namespace kdstream::fixtures
{

std::unique_ptr<Model> MakeModel(const Mesh& mesh, const KdTreeOptions& treeOptions,
  const LevelOptions& levelOptions, const Execution& execution, unsigned onePiece)
{
  auto model = std::make_unique<Model>();
  model->mesh = mesh;
  model->tree = *BuildKdTree(mesh.points, treeOptions, execution);
  model->tree.depths.onePiece = onePiece;
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

Cut CutShowing(const Model& model, Resolution base, const std::vector<PieceId>& wanted)
{
  return { model.tree.depths, base,
    MakeClosure(model.tree.depths, base, wanted, model.Lookup()).pieces };
}

std::vector<Surface::Source> CutOfVertices(const Model& model, const Cut& cut)
{
  const VertexTree& tree = model.vertexTree;
  const unsigned finest = tree.depths.finest;
  // The ranks of every vertex's ancestors, at all levels.
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
  const auto isActive = [&](Resolution resolution, std::uint32_t partition)
  {
    return std::binary_search(
      cut.active.begin(), cut.active.end(), PieceOfPartition(resolution, partition, tree.depths));
  };
  // The finest resolution of which all pieces are there.
  Resolution base = cut.base;
  for (unsigned d = 0; d <= finest + 1; ++d)
  {
    const Resolution resolution = d > finest ? Resolution::Original() : Resolution::Level(d);
    bool whole = resolution > base;
    for (std::uint32_t p = 0; whole && p < 1U << tree.depths.partition; ++p)
    {
      whole = isActive(resolution, p);
    }
    base = whole ? resolution : base;
  }
  // Levels coarser than S. A cluster whose child pieces are all active is shown by its children, if
  // the base is a level of several pieces, or if the cluster's parent is split.
  const unsigned stitch = tree.depths.stitch;
  std::vector<Resolution> shownAt(n, base);
  for (unsigned d = base.IsOriginal() ? stitch : base.Depth(); d < stitch; ++d)
  {
    if (d < PreviewLevel(tree.depths))
    {
      break;
    }
    const std::vector<VertexTreeLevel>& levels = tree.levels;
    std::vector<std::uint8_t> split(levels[d].first.size(), 1);
    for (VertexId child = 0; child < levels[d + 1].first.size(); ++child)
    {
      if (!isActive(Resolution::Level(d + 1), tree.PartitionOf(levels[d + 1].first[child])))
      {
        split[levels[d + 1].parents[child]] = 0;
      }
    }
    for (VertexId v = 0; v < n; ++v)
    {
      if (shownAt[v] == Resolution::Level(d) && split[at[d][v]])
      {
        shownAt[v] = Resolution::Level(d + 1);
      }
    }
  }
  std::vector<Surface::Source> nodes(n);
  for (VertexId v = 0; v < n; ++v)
  {
    Resolution shown = shownAt[v];
    for (unsigned d = stitch; shown >= Resolution::Level(stitch) && d <= finest + 1; ++d)
    {
      const Resolution resolution = d > finest ? Resolution::Original() : Resolution::Level(d);
      if (resolution > shown && isActive(resolution, tree.PartitionOf(v)))
      {
        shown = resolution;
      }
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
