// SPDX-License-Identifier: BSD-3-Clause
// The normals, colours and numbers of levels: the last part of step "levels" of the pipeline
// picture.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterLevels.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// Gives every level the attributes that a viewer uses, with the name and type that they have in the
// mesh: normals, colours (RoleOf), numbers (IsScalar) and classes (HoldsClasses). Only the original
// has other arrays (ArraysOfLevels).
// - Colours: the mean of the linear light (Light.h) of the cluster's original vertices, as the
//   nearest byte; alpha is averaged as it is, halves upwards. If the levels have colours of their
//   own (ClusterLevel::vertexColors), these replace red, green and blue of the array of the mesh's
//   colours.
// - Normals: the mean of the directions of the cluster's normals, of length 1. Tuples without a
//   direction (all zero, or a component that is NaN or infinite) are left out. If the directions
//   cancel (their sum is shorter than 10^-9 of their number), it is the direction of the lowest
//   original vertex that has one; if none has one, it is (0, 0, 0).
// - Numbers: ScalarSum of ScalarSums.h; integers are rounded to the nearest, halves away from 0.
// - Classes: the most frequent (ClassVotes of ScalarSums.h).
//
// Sums are in double, over original vertices ascending at the finest level, and over children by
// lowest vertex at coarser levels. Serial; O(n + c log c) for c clusters; AttributeSums of the
// finest level and the next. REQUIRES: CheckAttributes(mesh.attributes, …), levels of this mesh.
// See doc/design.md#attributes; the paper has no attributes.
void AddLevelAttributes(const Mesh& mesh, ClusterLevels& levels);

// The sums from which the means come, of all clusters of one level, or of those of one block of the
// tree (VertexNumbers.h): a cluster of a level >= S is made of vertices and clusters of its own
// block. The sums are bytes, one record for each cluster, so they can be kept in a file beside the
// rest of the level. The records of two blocks can be concatenated.
class AttributeSums
{
public:
  // Empty sums for this number of clusters. attributes: all those of the mesh, including those that
  // levels do not have (ArraysOfLevels).
  AttributeSums(std::span<const AttributeInfo> attributes, std::size_t clusters);
  // Restores sums from the result of Bytes(). Errors: InvalidInput if the bytes are not whole
  // records, or if those of a cluster, which the message names, cannot be sums of any values.
  static Result<AttributeSums> FromBytes(
    std::span<const AttributeInfo> attributes, std::vector<std::byte> bytes);

  // Adds the tuples of original vertices, which ascend by id, to their clusters. Vertices of other
  // blocks, whose cluster is noVertex, are skipped. attributes: of the vertices; must include those
  // that are summed. REQUIRES: one tuple for each vertex.
  void AddVertices(std::span<const Attribute> attributes, std::span<const VertexId> clusterOf);
  // The sums of the next coarser level's `count` clusters: over children by lowest original vertex.
  // parents, lowest: one entry for each cluster. O(c log c); 4 bytes a cluster beside the result.
  AttributeSums MakeCoarser(
    std::span<const VertexId> parents, std::span<const VertexId> lowest, std::size_t count) const;
  // The arrays of the level, each with one tuple for each cluster.
  std::vector<Attribute> Means() const;

  // Whether there is nothing to add up.
  bool Empty() const { return this->Columns.empty(); }
  std::size_t ClusterCount() const { return this->Clusters; }
  // Bytes of a cluster: 40 for colours, 56 for normals, 16 for numbers and 64 for classes; at most
  // 1160, for normals, RGB, RGBA and mostScalars classes.
  std::size_t RecordSize() const { return this->Record; }
  // Record after record, in the byte order of this machine.
  std::span<const std::byte> Bytes() const { return this->Records; }

private:
  struct Column
  {
    AttributeInfo attribute;
    std::size_t offset = 0; // in a record
  };

  AttributeSums() = default;
  template <class Visit>
  void ForEachColumn(const Visit& visit) const;
  Status Check() const;

  std::vector<Column> Columns;
  std::size_t Clusters = 0;
  std::size_t Record = 0;
  std::vector<std::byte> Records;
};

}
