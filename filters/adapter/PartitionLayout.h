// SPDX-License-Identifier: BSD-3-Clause
// Which vertices and elements go to which partition, and which partition owns them: the step
// between the tree and the VTK arrays. No VTK here.
#pragma once

#include "filters/core/TriangleBuckets.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// One partition: its own vertices, the ghost vertices that complete its boundary, and every element
// that touches an own vertex.
struct PartitionPiece
{
  std::vector<VertexId> vertices;      // own ones, ascending; then ghosts, ascending
  std::size_t owned = 0;               // how many of the vertices are own
  std::vector<std::uint32_t> elements; // ascending
  std::vector<Triangle> corners;       // of the elements, as indices into `vertices`
  std::vector<std::uint8_t> duplicate; // 1 if a partition of a lower number owns the element
};

// Distributes elements (triangles, segments {a, b, b}, vertices {a, a, a}) to the partitions of
// their corners. An element goes to each partition that it touches; the lowest one owns it.
// O(vertices + elements). Memory: 16 bytes a vertex, about 4.3 an element.
class PartitionLayout
{
public:
  // partitionOf: for each vertex a number below `partitions`. Keeps a reference to the elements.
  PartitionLayout(std::vector<std::uint32_t> partitionOf, std::size_t partitions,
    std::span<const Triangle> elements);

  std::uint32_t PartitionOf(VertexId vertex) const { return this->Partition[vertex]; }
  // May be called by any number of threads at the same time.
  PartitionPiece Cut(std::size_t partition) const;

private:
  std::vector<std::uint32_t> Partition;
  std::vector<std::size_t> OwnBegin; // index in Own where each partition begins, and the end
  std::vector<VertexId> Own;         // vertices by partition, ascending
  std::vector<VertexId> PlaceInOwn;  // index of each vertex among the own vertices of its partition
  std::span<const Triangle> Elements;
  TriangleBuckets Buckets;
};

}
