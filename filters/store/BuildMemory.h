// How much memory a build in memory takes, and whether a limit allows it.
#pragma once

#include "filters/core/KdTree.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <string>

namespace kdstream
{

// What decides how much memory a mesh takes.
struct MeshSize
{
  std::uint64_t vertices = 0, triangles = 0;
  std::uint64_t attributeBytes = 0; // of all arrays
};
MeshSize SizeOf(const Mesh& mesh);

// Bytes that a build in memory takes at most, measured on surfaces, clouds, soups and meshes with
// attributes (Programs.StaysBelowTheMemoryLimit). partitions: some are held while they are encoded.
// clusters: of the finest level, at least one a cell, at most four; known once the sheets are
// found.
std::uint64_t EstimateBuildMemory(
  const MeshSize& size, std::uint64_t partitions, std::uint64_t clusters);

// Partitions that are encoded before they are written.
inline constexpr std::size_t encodeBatch = 64;

// Whether `limit` bytes (0 = no limit) allow the mesh the least that it needs: a cluster a cell.
// Errors: LimitExceeded.
Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit);

// The most clusters of the finest level that `limit` leaves room for; 0 = no limit.
std::uint64_t MostClusters(const MeshSize& size, std::uint64_t partitions, std::uint64_t limit);

// LimitExceeded: `what` cannot be had with `limit` bytes.
Error BeyondMemory(const std::string& what, std::uint64_t limit);

}
