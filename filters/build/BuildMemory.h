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

// Memory that is free now, in bytes: the smaller of what the machine and the control group have.
std::uint64_t FreeMemory();

// What decides how much memory a mesh takes.
struct MeshSize
{
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t attributeBytes = 0; // of all arrays
  std::uint64_t sumBytes = 0;       // SumBytesOf its arrays
};
MeshSize SizeOf(const Mesh& mesh);

// Bytes of the sums (AttributeSums) that give a cluster its numbers and classes. The sums of
// normals and colours are not counted: every cluster has room for them.
std::uint64_t SumBytesOf(std::span<const AttributeInfo> attributes);

// Bytes that a build in memory takes at most, measured on surfaces, clouds, soups and meshes with
// attributes (BuildMemory.StaysBelowTheMemoryLimit). partitions: several, or a single large one,
// are in memory while they are encoded. clusters: of the finest level, one to four for each cell;
// known when the sheets have been found.
std::uint64_t EstimateBuildMemory(
  const MeshSize& size, std::uint64_t partitions, std::uint64_t clusters);

// Bytes that reading and welding take at most: measured on binary STL.
std::uint64_t EstimateWeldMemory(const MeshSize& size);

// Checks that `limit` bytes (0 = no limit) are enough to take this number of unused vertices out of
// the mesh. Errors: LimitExceeded.
Status CheckPartingMemory(const MeshSize& size, std::uint64_t unused, std::uint64_t limit);

// Checks that `limit` bytes (0 = no limit) are enough for the least that the mesh needs: one
// cluster for each cell. Errors: LimitExceeded.
Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit);

// The same check before welding, which may merge most of the vertices. With more vertices than
// triangles (an STL, which repeats all corners) the number after welding is unknown. Then the
// smallest number that a closed surface can have is used, and CheckBuildMemory checks afterwards.
// Errors: LimitExceeded.
Status CheckUnweldedMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit);

// The most clusters of the finest level that `limit` leaves room for; 0 = no limit.
std::uint64_t MostClusters(const MeshSize& size, std::uint64_t partitions, std::uint64_t limit);

// For a build in blocks, out of core or on several ranks: the part of a limit that its steps may
// use; libraries, threads and SQLite take the rest.
std::uint64_t StepMemory(std::uint64_t limit);

// How much of that a process may hold while freed memory stays with it (ReturnFreeMemory).
std::uint64_t KeptMemory(std::uint64_t stepMemory);

// What decides how much memory a block takes.
struct BlockedSize
{
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t pointTupleBytes = 0, cellTupleBytes = 0; // of one vertex, of one triangle
};
// The depth, `least` to `most`, of the largest blocks of which one fits the memory in every step.
unsigned DepthOfBlocks(
  const BlockedSize& mesh, std::uint64_t memory, unsigned least, unsigned most);

// The most vertices that a block may have, of a mesh whose vertices take the same everywhere.
std::uint64_t MostBlockVertices(const BlockedSize& mesh, std::uint64_t memory);

// The most bytes of files that a build out of core is likely to have at one time. soup: as in
// MeshFileInfo; the vertices are then the triangles' corners. Measured; 0 for no vertices.
std::uint64_t EstimateTemporaryBytes(const BlockedSize& mesh, bool soup, ScalarType scalars);

// Checks that `limit` bytes are enough to make partitions in blocks; a block has at least one
// partition. Some sizes may be lower bounds. mayBeWhole: a limit that holds the whole mesh is also
// enough, because kdstream-build then builds in memory; ranks do not. O(1). Errors: LimitExceeded,
// naming a limit that is enough.
Status CheckPartitionMemory(
  const BlockedSize& mesh, const KdTreeOptions& tree, std::uint64_t limit, bool mayBeWhole = true);

// "64 MiB", "12 KiB": for messages.
std::string Mebibytes(std::uint64_t bytes);

// LimitExceeded: `limit` bytes are not enough for `what`.
Error BeyondMemory(const std::string& what, std::uint64_t limit);

}
