// SPDX-License-Identifier: BSD-3-Clause
// A mesh processed by core as a whole, and the data that a block of it has: for tests of working
// block by block.
#pragma once

#include "Testing/Fixtures/Meshes.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/pieces/LeafOrder.h"
#include "filters/core/pieces/VertexNumbers.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace kdstream::fixtures
{

// With the last ones, levels finer than S are cut into several pieces.
inline const KdTreeOptions blockOptions[] = { { 300, {}, 8 }, { 20, {}, 4 }, { 2000, {}, 8 },
  { 1, {}, 1 }, { 300, {}, 1 }, { 3000, {}, 2 } };

// Adds normals and colours, some of them missing, and arrays of vertices and triangles. There are
// few different values, so that equal triangles sometimes have equal tuples.
inline Mesh WithColors(Mesh mesh, std::uint32_t seed)
{
  std::mt19937 random(seed);
  const auto add = [&](const std::string& name, AttributeType type,
                     AttributeAssociation association, std::uint8_t components)
  {
    Attribute array{ { name, type, association, components }, {} };
    const std::size_t tuples =
      association == AttributeAssociation::Point ? mesh.points.size() : mesh.triangles.size();
    array.values.resize(tuples * array.TupleSize());
    for (std::size_t i = 0; i < tuples; ++i)
    {
      for (std::size_t k = 0; k < components; ++k)
      {
        const bool none = type == AttributeType::Float32 && random() % 16 == 0;
        array.Set(i, k,
          none ? std::numeric_limits<double>::quiet_NaN() : double(random() % 1000) / 4 - 100);
      }
    }
    mesh.attributes.push_back(std::move(array));
  };
  add("Normals", AttributeType::Float32, AttributeAssociation::Point, 3);
  add("number", AttributeType::Int32, AttributeAssociation::Cell, 2);
  add("RGB", AttributeType::UInt8, AttributeAssociation::Point, 3);
  add("any", AttributeType::Float64, AttributeAssociation::Point, 1);
  return mesh;
}

// A mesh processed by core in memory, and the data from which blocks are made.
struct Whole
{
  Mesh mesh;
  KdTree tree;
  ClusterLevels levels;
  VertexTree numbered;
  std::vector<std::uint32_t> partition;         // of each vertex
  std::vector<std::vector<VertexId>> ancestors; // [depth][vertex]: cluster
  std::vector<std::vector<VertexId>> counts;    // [depth][cluster]: original vertices
  std::vector<VertexId> numberOf;               // numbered vertex of each vertex

  const TreeDepths& Depths() const { return this->tree.depths; }
  ClusterParents Links(std::size_t d) const
  {
    const ClusterLevel& level = this->levels.levels[d];
    return { level.parents, level.lowest, level.positions };
  }
  std::uint32_t BlockOfVertex(VertexId v, unsigned depth) const
  {
    return this->partition[v] >> (this->Depths().partition - depth);
  }
  // Clusters of a level >= S that lie in a block: [first, second).
  std::pair<VertexId, VertexId> Own(std::size_t d, unsigned depth, std::uint32_t block) const
  {
    const std::vector<VertexId>& lowest = this->levels.levels[d].lowest;
    const auto below = [&](std::uint32_t limit)
    {
      return static_cast<VertexId>(
        std::partition_point(lowest.begin(), lowest.end(),
          [&](VertexId v) { return this->BlockOfVertex(v, depth) < limit; }) -
        lowest.begin());
    };
    return { below(block), below(block + 1) };
  }
};

inline Whole MakeWhole(const Mesh& mesh, const KdTreeOptions& options, LevelMaker maker)
{
  Whole whole;
  whole.mesh = mesh;
  whole.tree = *BuildKdTree(mesh.points, options);
  whole.partition = CellOfVertex(whole.tree, whole.Depths().partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << whole.Depths().partition, [&](VertexId v) { return whole.partition[v]; });
  LevelOptions levelOptions;
  levelOptions.maker = maker;
  whole.levels = *BuildLevels(mesh, whole.tree, buckets, levelOptions);
  whole.numbered = NumberVertices(whole.tree, whole.levels, MakeTbbExecution(2));
  OrderLeaves(whole.numbered, mesh.points);
  const std::size_t levels = whole.levels.levels.size();
  whole.ancestors.resize(levels);
  whole.counts.resize(levels);
  for (std::size_t d = levels; d-- > 0;)
  {
    whole.ancestors[d] = d + 1 == levels ? whole.levels.finest : whole.ancestors[d + 1];
    whole.counts[d].assign(whole.levels.levels[d].lowest.size(), 0);
    for (VertexId& cluster : whole.ancestors[d])
    {
      cluster = d + 1 == levels ? cluster : whole.levels.levels[d + 1].parents[cluster];
      ++whole.counts[d][cluster];
    }
  }
  whole.numberOf.resize(mesh.points.size());
  for (VertexId i = 0; i < whole.numberOf.size(); ++i)
  {
    whole.numberOf[whole.numbered.original[i]] = i;
  }
  return whole;
}

template <class Check>
void ForAllBlockMeshes(const Check& check)
{
  std::vector<NamedMesh> meshes = ClosedMeshes();
  meshes.push_back({ "painted torus", WithColors(Torus(90, 60), 1) });
  meshes.push_back({ "painted soup", WithColors(Soup(500, 3), 2) });
  for (NamedMesh& hard : HardMeshes())
  {
    meshes.push_back({ "painted " + hard.name, WithColors(std::move(hard.mesh), 3) });
  }
  for (const NamedMesh& named : meshes)
  {
    for (const KdTreeOptions& options : blockOptions)
    {
      if (options.verticesPerPartition < 20 && named.mesh.points.size() > 2000)
      {
        continue; // thousands of partitions of one vertex test nothing new
      }
      for (const LevelMaker maker : { LevelMaker::Collapse, LevelMaker::Cluster })
      {
        SCOPED_TRACE(named.name + ", " + std::to_string(options.verticesPerPartition) +
                     " a partition, maker " + std::to_string(int(maker)));
        check(MakeWhole(named.mesh, options, maker));
      }
    }
  }
}

inline std::vector<unsigned> BlockDepths(const Whole& whole)
{
  const unsigned partition = whole.Depths().partition;
  const std::set<unsigned> depths{ 0, std::min(1U, partition), partition / 2, partition };
  return { depths.begin(), depths.end() };
}

// The vertices of a level or of the original that a block has, ascending, and the place of each in
// this list.
struct AtHand
{
  std::vector<VertexId> vertices; // own and ghosts, as in the whole
  std::vector<VertexId> local;    // of each vertex of the whole; noVertex: not in the block
  std::vector<std::uint32_t> triangles;

  // Takes the own ones of `count` vertices, and those that share a triangle with them.
  template <class IsOwn>
  AtHand(std::size_t count, std::span<const Triangle> all, const IsOwn& isOwn)
    : local(count, noVertex)
  {
    for (VertexId v = 0; v < count; ++v)
    {
      this->local[v] = isOwn(v) ? 0 : noVertex;
    }
    for (std::uint32_t t = 0; t < all.size(); ++t)
    {
      if (std::any_of(all[t].begin(), all[t].end(), isOwn))
      {
        this->triangles.push_back(t);
        for (const VertexId v : all[t])
        {
          this->local[v] = 0;
        }
      }
    }
    for (VertexId v = 0; v < count; ++v)
    {
      if (this->local[v] == 0)
      {
        this->local[v] = static_cast<VertexId>(this->vertices.size());
        this->vertices.push_back(v);
      }
    }
  }

  template <class T>
  std::vector<T> Take(const std::vector<T>& values) const
  {
    std::vector<T> taken;
    for (const VertexId v : this->vertices)
    {
      taken.push_back(values[v]);
    }
    return taken;
  }
  std::vector<Triangle> Take(std::span<const Triangle> all) const
  {
    std::vector<Triangle> taken;
    for (const std::uint32_t t : this->triangles)
    {
      taken.push_back({ this->local[all[t][0]], this->local[all[t][1]], this->local[all[t][2]] });
    }
    return taken;
  }
  std::vector<Attribute> Take(const std::vector<Attribute>& attributes) const
  {
    std::vector<Attribute> taken;
    for (const Attribute& array : attributes)
    {
      Attribute& part = taken.emplace_back(Attribute{ array.Info(), {} });
      for (const VertexId tuple :
        array.association == AttributeAssociation::Point ? this->vertices : this->triangles)
      {
        part.Append(array, tuple);
      }
    }
    return taken;
  }
};

// The original vertices that a block has.
inline AtHand OriginalsOf(const Whole& whole, unsigned depth, std::uint32_t block)
{
  return { whole.mesh.points.size(), whole.mesh.triangles,
    [&, depth, block](VertexId v) { return whole.BlockOfVertex(v, depth) == block; } };
}

inline Mesh MeshOf(const Whole& whole, const AtHand& at)
{
  Mesh mesh;
  mesh.points = at.Take(whole.mesh.points);
  mesh.triangles = at.Take(std::span<const Triangle>(whole.mesh.triangles));
  mesh.attributes = at.Take(whole.mesh.attributes);
  return mesh;
}

}
