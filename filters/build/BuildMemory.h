// SPDX-License-Identifier: BSD-3-Clause
// How much memory a build in memory takes, and whether a limit allows it.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <string>

namespace kdstream
{

// Memory that is free now, in bytes: the smaller of what the machine and the control group have
// left.
std::uint64_t FreeMemory();

// What determines how much memory a mesh takes.
struct MeshSize
{
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t attributeBytes = 0; // of all arrays
  std::uint64_t sumBytes = 0;       // SumBytesOf for its arrays
};

// Bytes of the sums (AttributeSums) from which a cluster gets its numbers and classes. Sums of
// normals and colours are not counted: every cluster has room for them anyway.
std::uint64_t SumBytesOf(std::span<const AttributeInfo> attributes);

// The most bytes that a build in memory takes for a mesh of at most this size, whatever welding
// leaves, and however many vertices no triangle uses. clustersOfCell: maximum in each cell of the
// finest level (mostCellComponents; 1 without components and levels). Measured on surfaces, clouds,
// soups and meshes with attributes (BuildMemory.StaysBelowTheMemoryLimit).
std::uint64_t MostBuildMemory(
  const MeshSize& size, const KdTreeOptions& tree, std::uint64_t clustersOfCell);

// Checks that `limit` bytes (0 = no limit) are enough. Errors: LimitExceeded.
Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree,
  std::uint64_t clustersOfCell, std::uint64_t limit);

// For a build in blocks, out of core or on several ranks: the part of a limit that its steps may
// use. Libraries, threads and SQLite take the rest.
std::uint64_t StepMemory(std::uint64_t limit);

// How much of the step memory a process may hold before freed memory is returned
// (ReturnFreeMemory).
std::uint64_t KeptMemory(std::uint64_t stepMemory);

// What determines how much memory a block takes.
struct BlockedSize
{
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t pointTupleBytes = 0, cellTupleBytes = 0; // for one vertex, for one triangle
};
// The smallest depth of blocks, from `least` to `most`, at which one block fits in memory in every
// step.
unsigned DepthOfBlocks(
  const BlockedSize& mesh, std::uint64_t memory, unsigned least, unsigned most);

// The maximum number of vertices of a block, if all vertices of the mesh take the same memory.
std::uint64_t MostBlockVertices(const BlockedSize& mesh, std::uint64_t memory);

// The maximum bytes of files that a build out of core will probably have at one time. soup: as in
// MeshFileInfo; the vertices are then the corners of the triangles. Measured; 0 for no vertices.
std::uint64_t EstimateTemporaryBytes(const BlockedSize& mesh, bool soup, ScalarType scalars);

// Checks that partitions can be made in blocks within `limit` bytes; a partition is never divided.
// Some sizes in `mesh` may be lower bounds of the real ones. O(1). Errors: LimitExceeded, with the
// limit that would be enough.
Status CheckPartitionMemory(
  const BlockedSize& mesh, const KdTreeOptions& tree, std::uint64_t limit);

// A size for messages: "64 MiB", "12 KiB".
std::string Mebibytes(std::uint64_t bytes);

// LimitExceeded: `limit` bytes are not enough for `what`.
Error BeyondMemory(const std::string& what, std::uint64_t limit);

}
