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

// Bytes of the sums from which a cluster has its numbers and classes (AttributeSums); those of
// normals and colours are in what a cluster takes anyway.
std::uint64_t SumBytesOf(std::span<const AttributeInfo> attributes);

// Bytes that a build in memory takes at most, measured on surfaces, clouds, soups and meshes with
// attributes (BuildMemory.StaysBelowTheMemoryLimit). partitions: some, or one that is large, are
// held while they are encoded. clusters: of the finest level, at least one a cell, at most four;
// known once the sheets are found.
std::uint64_t EstimateBuildMemory(
  const MeshSize& size, std::uint64_t partitions, std::uint64_t clusters);

// Bytes that reading and welding take at most: measured on binary STL.
std::uint64_t EstimateWeldMemory(const MeshSize& size);

// Whether `limit` bytes (0 = no limit) allow to take so many unused vertices out of the mesh.
// Errors: LimitExceeded.
Status CheckPartingMemory(const MeshSize& size, std::uint64_t unused, std::uint64_t limit);

// Whether `limit` bytes (0 = no limit) allow the mesh the least that it needs: a cluster a cell.
// Errors: LimitExceeded.
Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit);

// The same before welding, which may leave few of the vertices. With more vertices than triangles
// (an STL: all corners) the result of welding is unknown: the least that a closed surface keeps is
// counted, and CheckBuildMemory checks afterwards. Errors: LimitExceeded.
Status CheckUnweldedMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit);

// The most clusters of the finest level that `limit` leaves room for; 0 = no limit.
std::uint64_t MostClusters(const MeshSize& size, std::uint64_t partitions, std::uint64_t limit);

// Of a build in blocks, out of core or on several ranks: what is left of a limit for its steps;
// libraries, threads and SQLite take the rest.
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

// The most bytes of files that a build out of core is likely to have at one time. soup: as
// MeshFileInfo has it, when the vertices are the triangles' corners. Measured; 0 for no vertices.
std::uint64_t EstimateTemporaryBytes(const BlockedSize& mesh, bool soup, ScalarType scalars);

// Whether partitions can be made in blocks within `limit` bytes: a partition is never divided. Of
// some sizes only the least may be known. mayBeWhole: a limit that holds the whole mesh does, too,
// as kdstream-build then builds it in memory; ranks do not. O(1). Errors: LimitExceeded, with what
// a limit must be.
Status CheckPartitionMemory(
  const BlockedSize& mesh, const KdTreeOptions& tree, std::uint64_t limit, bool mayBeWhole = true);

// "64 MiB", "12 KiB": for messages.
std::string Mebibytes(std::uint64_t bytes);

// LimitExceeded: `what` cannot be had with `limit` bytes.
Error BeyondMemory(const std::string& what, std::uint64_t limit);

}
