// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/BuildMemory.h"

#include "filters/build/PieceWriting.h"
#include "filters/core/levels/LevelAttributes.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::uint64_t bytesPerCluster = 560; // measured

// The sums of two levels are in memory at the same time; one level has half the clusters of the
// other.
std::uint64_t BytesPerCluster(const MeshSize& size)
{
  return bytesPerCluster + size.sumBytes * 3 / 2;
}

// The part of a limit that is kept for libraries, threads and SQLite.
constexpr std::uint64_t mostKeptFromSteps = std::uint64_t{ 96 } << 20;

// The maximum number of bytes of a block in any step, for each of its vertices: measured on
// surfaces and soups (Testing/EndToEnd).
constexpr std::uint64_t bytesPerBlockVertex = 600;
// For each triangle beyond two per vertex, which is the number on a surface.
constexpr std::uint64_t bytesPerBlockTriangle = 100;

// Measured: memory of one large piece while it is cut and encoded, beyond that of a batch of small
// pieces.
constexpr std::uint64_t bytesPerPieceVertex = 400;
constexpr std::uint64_t bytesPerPieceTriangle = 50; // for each triangle beyond two per vertex

std::uint64_t BytesOfBlocks(const BlockedSize& mesh)
{
  const std::uint64_t beyondSurface = mesh.triangles - std::min(mesh.triangles, 2 * mesh.vertices);
  return mesh.vertices * (bytesPerBlockVertex + 3 * mesh.pointTupleBytes) +
         beyondSurface * bytesPerBlockTriangle + mesh.triangles * 3 * mesh.cellTupleBytes;
}

std::uint64_t BytesOfLargePieces(const MeshSize& size, std::uint64_t partitions)
{
  const std::uint64_t largest = size.vertices / std::max<std::uint64_t>(1, partitions);
  const std::uint64_t triangles = size.triangles / std::max<std::uint64_t>(1, partitions);
  const std::uint64_t beyondBatch = largest - std::min<std::uint64_t>(largest, encodeBatchVertices);
  return beyondBatch == 0
           ? 0
           : bytesPerPieceVertex * beyondBatch +
               bytesPerPieceTriangle * (triangles - std::min(triangles, 2 * largest));
}

}

std::string Mebibytes(std::uint64_t bytes)
{
  return bytes < 1 << 10   ? std::to_string(bytes) + " bytes"
         : bytes < 1 << 20 ? std::to_string(bytes >> 10) + " KiB"
                           : std::to_string(bytes >> 20) + " MiB";
}

std::uint64_t SumBytesOf(std::span<const AttributeInfo> attributes)
{
  std::vector<AttributeInfo> numbers = ArraysOfLevels(attributes);
  std::erase_if(numbers, [](const AttributeInfo& array) { return !IsScalar(array); });
  return AttributeSums(numbers, 0).RecordSize();
}

std::uint64_t MostBuildMemory(
  const MeshSize& size, const KdTreeOptions& tree, std::uint64_t clustersOfCell)
{
  KdTreeOptions cells = tree;
  Result<TreeDepths> depths = ComputeDepths(size.vertices, cells);
  // Either only a baseline can make this number of partitions, or the mesh will be refused.
  if (!depths)
  {
    cells.partitions.reset();
    depths = ComputeDepths(size.vertices, cells);
  }
  // Welding may leave fewer vertices, and so fewer partitions. Each partition is at most as large.
  const std::uint64_t partitions = std::max<std::uint64_t>(
    1, tree.partitions.value_or(static_cast<std::uint32_t>(
         size.vertices / std::max<std::uint32_t>(1, tree.verticesPerPartition))));
  const std::uint64_t ofCell = size.triangles > 0 ? clustersOfCell : 1;
  const std::uint64_t clusters =
    depths ? std::min(size.vertices, ofCell << depths->finest) : std::uint64_t{ 0 };
  // The arrays, and once more while they grow; for a batch its pieces, their blobs, and what SQLite
  // holds.
  const std::uint64_t inBatch =
    std::min<std::uint64_t>(size.attributeBytes, size.attributeBytes / partitions * encodeBatch);
  constexpr std::uint64_t always = std::uint64_t{ 32 } << 20;
  const std::uint64_t built = 44 * size.vertices + 40 * size.triangles + 2 * size.attributeBytes +
                              3 * inBatch + BytesPerCluster(size) * clusters +
                              BytesOfLargePieces(size, partitions);
  // Unused vertices are in memory twice while they are removed, and take 48 bytes each until the
  // end.
  const std::uint64_t withUnused =
    size.triangles == 0 ? built
                        : std::max(built + 4 * size.vertices,
                            52 * size.vertices + 12 * size.triangles + 2 * size.attributeBytes);
  return always + withUnused;
}

Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree,
  std::uint64_t clustersOfCell, std::uint64_t limit)
{
  const std::uint64_t need = limit == 0 ? 0 : MostBuildMemory(size, tree, clustersOfCell);
  if (need <= limit && (limit == 0 || size.triangles < noVertex))
  {
    return {};
  }
  return Error{ ErrorCode::LimitExceeded, "may need " + Mebibytes(need) + " of memory for " +
                                            std::to_string(size.vertices) + " vertices and up to " +
                                            std::to_string(size.triangles) +
                                            " triangles; the limit is " + Mebibytes(limit) };
}

std::uint64_t StepMemory(std::uint64_t limit)
{
  return limit - std::min<std::uint64_t>(limit / 4, mostKeptFromSteps);
}

std::uint64_t KeptMemory(std::uint64_t stepMemory)
{
  // Memory that one thread has freed is not always reused by another, so its amount is bounded.
  return std::min(stepMemory, std::uint64_t{ 192 } << 20);
}

unsigned DepthOfBlocks(const BlockedSize& mesh, std::uint64_t memory, unsigned least, unsigned most)
{
  const std::uint64_t bytes = BytesOfBlocks(mesh);
  unsigned depth = least;
  while (depth < most && (bytes >> depth) > memory)
  {
    ++depth;
  }
  return depth;
}

std::uint64_t MostBlockVertices(const BlockedSize& mesh, std::uint64_t memory)
{
  const std::uint64_t ofVertex =
    (BytesOfBlocks(mesh) + mesh.vertices - 1) / std::max<std::uint64_t>(1, mesh.vertices);
  return std::max<std::uint64_t>(1, memory / std::max<std::uint64_t>(1, ofVertex));
}

Status CheckPartitionMemory(const BlockedSize& mesh, const KdTreeOptions& tree, std::uint64_t limit)
{
  const Result<TreeDepths> depths = ComputeDepths(mesh.vertices, tree);
  if (!depths)
  {
    return {}; // reported when the tree is made
  }
  const unsigned depth = depths->partition;
  const std::uint64_t bytes = BytesOfBlocks(mesh) >> depth;
  if (bytes <= StepMemory(limit))
  {
    return {};
  }
  // The memory limit that leaves `bytes` for the steps.
  const std::uint64_t need = std::min(bytes / 3 * 4, bytes + mostKeptFromSteps);
  constexpr std::uint64_t mebibyte = std::uint64_t{ 1 } << 20;
  const std::uint64_t largest = (mesh.vertices + (std::uint64_t{ 1 } << depth) - 1) >> depth;
  return Error{ ErrorCode::LimitExceeded,
    "partitions of " + std::to_string(largest) + " vertices need about " +
      Mebibytes(need + mebibyte - 1) + " of memory; the limit (--memory) is " + Mebibytes(limit) +
      ": raise it, or make smaller partitions" }; // rounded up, so that this limit is not refused
}

std::uint64_t EstimateTemporaryBytes(const BlockedSize& mesh, bool soup, ScalarType scalars)
{
  const std::uint64_t welding = 68 * mesh.vertices + 16 * mesh.triangles;
  if (mesh.vertices == 0)
  {
    return 0;
  }
  const std::uint64_t ofDoubles = scalars == ScalarType::Float64 ? 24 : 0;
  const std::uint64_t later =
    (60 + ofDoubles) * mesh.vertices + 52 * mesh.triangles + (std::uint64_t{ 4 } << 20);
  const std::uint64_t tuples =
    mesh.vertices * mesh.pointTupleBytes + mesh.triangles * mesh.cellTupleBytes;
  return (soup ? welding : std::max(welding, later)) + 5 * tuples / 2;
}

Error BeyondMemory(const std::string& what, std::uint64_t limit)
{
  return { ErrorCode::LimitExceeded, what + " with " + Mebibytes(limit) + " of memory" };
}

std::uint64_t FreeMemory()
{
  std::uint64_t free = std::uint64_t{ 1 } << 62;
  std::ifstream machine("/proc/meminfo");
  for (std::string key, unit; machine >> key;)
  {
    std::uint64_t kibibytes = 0;
    machine >> kibibytes;
    std::getline(machine, unit);
    if (key == "MemAvailable:")
    {
      free = kibibytes << 10;
    }
  }
  std::uint64_t limit = 0, used = 0;
  std::ifstream groupLimit("/sys/fs/cgroup/memory.max"), groupUse("/sys/fs/cgroup/memory.current");
  if (groupLimit >> limit && groupUse >> used && limit > used)
  {
    free = std::min(free, limit - used);
  }
  return free;
}

}
