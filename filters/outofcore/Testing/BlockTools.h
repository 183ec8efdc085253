// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of blocks: a mesh taken through the steps of a build up to the blocks, and
// the same mesh in memory.
#pragma once

#include "filters/core/Weld.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/outofcore/mesh/TreeBlock.h"
#include "filters/outofcore/tree/ExternalTree.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace kdstream::testing
{

template <class Scalar>
SpillFile SpilledRecords(SpillFolder& folder, const std::vector<Vec3>& points)
{
  std::vector<PointRecord<Scalar>> records;
  for (const Vec3& p : points)
  {
    records.push_back(
      { { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, static_cast<VertexId>(records.size()) });
  }
  return Spilled(folder, records);
}

// The tuples of a mesh's arrays of one association, element by element.
inline std::vector<std::byte> TuplesOf(
  const Mesh& mesh, AttributeAssociation association, std::size_t count)
{
  std::vector<std::byte> tuples;
  for (std::size_t i = 0; i < count; ++i)
  {
    for (const Attribute& array : mesh.attributes)
    {
      if (array.association == association)
      {
        const auto tuple =
          std::as_bytes(std::span(array.values)).subspan(i * array.TupleSize(), array.TupleSize());
        tuples.insert(tuples.end(), tuple.begin(), tuple.end());
      }
    }
  }
  return tuples;
}

template <class Scalar>
struct SpilledTree
{
  Mesh mesh; // welded if asked for
  KdTree tree;

  SpillFolder folder = MakeSpillFolder();
  std::vector<AttributeInfo> attributes;
  VertexFiles vertices;
  SpillFile cellTuples;
  SpillFile triangles; // after welding
  SpillFile records;   // in the order of the tree
  VertexMap ranks;

  // REQUIRES: point arrays first.
  SpilledTree(const Mesh& input, std::uint64_t memory, std::uint32_t verticesPerPartition = 60,
    std::uint32_t cellVertices = 8, bool weld = true)
    : mesh(input)
  {
    if (weld)
    {
      WeldVertices(this->mesh);
    }
    KdTreeOptions options;
    options.verticesPerPartition = verticesPerPartition;
    options.cellVertices = cellVertices;
    this->tree = std::move(*BuildKdTree(this->mesh.points, options));
    this->SpillAttributes(input);

    VertexFiles files;
    files.count = static_cast<std::uint32_t>(input.points.size());
    files.points = Spilled(this->folder, input.points);
    const auto tuples = TuplesOf(input, AttributeAssociation::Point, input.points.size());
    files.tupleBytes = tuples.size() / input.points.size();
    if (!tuples.empty())
    {
      files.tuples = Spilled(this->folder, tuples);
    }
    ExternalWeld welded;
    if (weld)
    {
      welded = std::move(*WeldExternally(this->folder, std::move(files), memory));
    }
    else
    {
      welded.vertices = std::move(files);
    }
    this->vertices = std::move(welded.vertices);
    this->SpillTriangles(input, welded.map, memory);

    SpillFile points = SpilledRecords<Scalar>(this->folder, ReadBack<Vec3>(this->vertices.points));
    ExternalTreeOptions external;
    external.memory = 1 << 20;
    this->records = std::move(
      BuildExternalTree<Scalar>(this->folder, points, this->tree.depths, external)->records);
    this->ranks =
      std::move(*RankVertices<Scalar>(this->folder, this->records, this->vertices.count, memory));
  }

  RecordBuckets<NumberedTriangle> Cells(unsigned depth, std::uint64_t memory)
  {
    return std::move(*SortTrianglesIntoCells(this->folder, this->triangles,
      this->mesh.triangles.size(), this->ranks, CellOfRank(this->ranks.count, depth), memory));
  }
  Result<TreeBlock> Block(
    const RecordBuckets<NumberedTriangle>& cells, unsigned depth, std::size_t cell) const
  {
    return LoadBlock<Scalar>(
      this->records, RangeOfCell(this->vertices.count, depth, cell), cells, cell);
  }

private:
  void SpillAttributes(const Mesh& input)
  {
    for (const Attribute& array : input.attributes)
    {
      this->attributes.push_back(array.Info());
    }
    const auto tuples = TuplesOf(input, AttributeAssociation::Cell, input.triangles.size());
    if (!tuples.empty())
    {
      this->cellTuples = Spilled(this->folder, tuples);
    }
  }

  void SpillTriangles(const Mesh& input, const std::optional<VertexMap>& map, std::uint64_t memory)
  {
    std::vector<NumberedTriangle> numbered;
    for (const Triangle& t : input.triangles)
    {
      numbered.push_back({ t, static_cast<std::uint32_t>(numbered.size()) });
    }
    this->triangles = Spilled(this->folder, numbered);
    if (!map)
    {
      return;
    }
    std::vector<NumberedTriangle> renumbered;
    EXPECT_TRUE(MapTriangles(this->folder, this->triangles, numbered.size(), *map, memory, {},
      [&](std::span<const NumberedTriangle> block) -> Status
      {
        renumbered.insert(renumbered.end(), block.begin(), block.end());
        return {};
      }));
    this->triangles = Spilled(this->folder, renumbered);
  }
};

}
