#include "filters/store/BuildMemory.h"

#include <algorithm>
#include <string>

namespace kdstream
{
namespace
{

constexpr std::uint64_t bytesPerCluster = 560; // measured

std::string Mebibytes(std::uint64_t bytes)
{
  return bytes < 1 << 20 ? std::to_string(bytes >> 10) + " KiB"
                         : std::to_string(bytes >> 20) + " MiB";
}

}

MeshSize SizeOf(const Mesh& mesh)
{
  MeshSize size{ mesh.points.size(), mesh.triangles.size() };
  for (const Attribute& attribute : mesh.attributes)
  {
    size.attributeBytes += attribute.values.size();
  }
  return size;
}

std::uint64_t EstimateBuildMemory(
  const MeshSize& size, std::uint64_t partitions, std::uint64_t clusters)
{
  // The arrays, once more while they grow; of a batch the pieces, their blobs and what SQLite
  // holds.
  const std::uint64_t inBatch = std::min<std::uint64_t>(size.attributeBytes,
    size.attributeBytes / std::max<std::uint64_t>(1, partitions) * encodeBatch);
  return (std::uint64_t{ 32 } << 20) + 44 * size.vertices + 40 * size.triangles +
         2 * size.attributeBytes + 3 * inBatch + bytesPerCluster * clusters;
}

Status CheckBuildMemory(const MeshSize& size, const KdTreeOptions& tree, std::uint64_t limit)
{
  const Result<TreeDepths> depths = ComputeDepths(size.vertices, tree);
  const std::uint64_t need =
    EstimateBuildMemory(size, depths ? std::uint64_t{ 1 } << depths->partition : 1,
      depths ? std::uint64_t{ 1 } << depths->finest : 0);
  if (limit == 0 || need <= limit)
  {
    return {};
  }
  return Error{ ErrorCode::LimitExceeded,
    "needs about " + Mebibytes(need) + " of memory for " + std::to_string(size.vertices) +
      " vertices and " + std::to_string(size.triangles) + " triangles; the limit is " +
      Mebibytes(limit) + " (building out of core is not supported yet)" };
}

std::uint64_t MostClusters(const MeshSize& size, std::uint64_t partitions, std::uint64_t limit)
{
  const std::uint64_t rest = EstimateBuildMemory(size, partitions, 0);
  return limit == 0
           ? 0
           : std::max<std::uint64_t>(1, limit > rest ? (limit - rest) / bytesPerCluster : 0);
}

Error BeyondMemory(const std::string& what, std::uint64_t limit)
{
  return { ErrorCode::LimitExceeded,
    what + " with " + Mebibytes(limit) + " of memory (building out of core is not supported yet)" };
}

}
