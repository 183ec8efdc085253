// SPDX-License-Identifier: BSD-3-Clause
#include "filters/baselines/stores/OctreePartitions.h"

#include "filters/baselines/stores/ExternalOctree.h"
#include "filters/core/tree/Clustering.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// Reports the step "octree" as the part [begin, end) of its progress, and earlier steps as `begin`.
Execution PartOf(const Execution& execution, double begin, double end)
{
  Execution part = execution;
  part.progress = [&execution, begin, end](std::string_view step, double fraction)
  { return execution.progress(step, step == "octree" ? begin + (end - begin) * fraction : begin); };
  return part;
}

template <class Scalar>
class Partitioning
{
public:
  using Record = PointRecord<Scalar>;

  Partitioning(SpillFolder& folder, SpillFile& points, const KdTreeOptions& options,
    std::uint64_t memory, const Execution& execution)
    : Folder(folder)
    , Points(points)
    , Count(points.Size() / sizeof(Record))
    , Options(options)
    , Memory(memory)
    , Exec(execution)
  {
  }

  Result<ExternalPartitions> Make()
  {
    Result<std::uint32_t> most = this->Options.partitions
                                   ? this->SearchSize(*this->Options.partitions)
                                   : Result<std::uint32_t>(this->Options.verticesPerPartition);
    KDSTREAM_TRY(most);
    Result<ExternalOctree> octree = this->Cluster(*most, false, this->Searched, 0.9);
    KDSTREAM_TRY(octree);
    ExternalPartitions result;
    result.begin.assign(octree->clusterBegin.begin(), octree->clusterBegin.end());
    octree->clusterBegin = {};
    result.records = std::move(octree->records);
    result.depths = DepthsOfClusters(result.begin.size() - 1);
    KDSTREAM_TRY(this->FindBoxes(result));
    result.recordsRead = this->RecordsRead + this->Count;
    return result;
  }

private:
  Result<ExternalOctree> Cluster(std::uint32_t most, bool keep, double begin, double end)
  {
    ExternalOctreeOptions options;
    options.verticesPerPartition = most;
    options.memory = this->Memory;
    options.keepPoints = keep;
    const Execution part = PartOf(this->Exec, begin, end);
    Result<ExternalOctree> octree =
      ClusterByExternalOctree<Scalar>(this->Folder, this->Points, options, part);
    if (octree)
    {
      // Passes for the box, for cells that do not fit in memory, and for each group.
      this->RecordsRead += 2 * this->Count + 2 * octree->statistics.distributedRecords;
    }
    return octree;
  }

  Result<std::uint64_t> CountClusters(std::uint64_t most)
  {
    const double begin = this->Searched;
    this->Searched += (0.8 - begin) / 8;
    const Result<ExternalOctree> octree =
      this->Cluster(static_cast<std::uint32_t>(most), true, begin, this->Searched);
    KDSTREAM_TRY(octree);
    return std::uint64_t{ octree->clusterBegin.size() - 1 };
  }

  // The size limit of partitions (in vertices) that gives about `wanted` partitions: the one that
  // ClusterByOctree would find. A smaller limit never gives fewer partitions.
  Result<std::uint32_t> SearchSize(std::uint64_t wanted)
  {
    if (wanted == 0)
    {
      return Error{ ErrorCode::InvalidArgument,
        "the number of partitions must be at least 1, not 0" };
    }
    if (wanted > this->Count)
    {
      return Error{ ErrorCode::InvalidArgument, "number of partitions " + std::to_string(wanted) +
                                                  " is above the number of vertices, " +
                                                  std::to_string(this->Count) };
    }
    // With a limit of `most` there are enough partitions; with `above` there are too few.
    std::uint64_t most = this->Count / wanted, above = this->Count, ofAbove = 1;
    Result<std::uint64_t> ofMost = this->CountClusters(most);
    for (; ofMost && *ofMost < wanted && most > 1; ofMost = this->CountClusters(most))
    {
      above = most; // if many vertices are in one place
      ofAbove = *ofMost;
      most /= 2;
    }
    while (ofMost && *ofMost >= wanted && above - most > 1 && most < this->Count)
    {
      // Try larger limits in steps: an octree has a few times as many partitions as necessary, not
      // many times as many.
      const std::uint64_t next = std::min(2 * most, most + (above - most) / 2);
      const Result<std::uint64_t> clusters = this->CountClusters(next);
      KDSTREAM_TRY(clusters);
      (*clusters >= wanted ? most : above) = next;
      (*clusters >= wanted ? *ofMost : ofAbove) = *clusters;
    }
    KDSTREAM_TRY(ofMost);
    const bool fewer = *ofMost > wanted && *ofMost - wanted >= wanted - ofAbove;
    return static_cast<std::uint32_t>(fewer ? above : most);
  }

  // Vertices are added one after the other, in the order of ids, because the order decides whether
  // a side is 0.0 or -0.0.
  Status FindBoxes(ExternalPartitions& result) const
  {
    const std::size_t partitions = std::size_t{ 1 } << result.depths.partition;
    result.boxes.resize(2 * partitions);
    RecordReader<Record> reader(result.records, 0, this->Count);
    std::size_t partition = 0;
    for (std::uint64_t rank = 0; rank < this->Count;)
    {
      const Result<std::span<const Record>> block = reader.Next();
      KDSTREAM_TRY(block);
      for (const Record& record : *block)
      {
        partition += rank++ == result.begin[partition + 1] ? 1 : 0;
        result.boxes[partitions + partition].Add(
          Vec3{ double(record.p[0]), double(record.p[1]), double(record.p[2]) });
      }
      const double done = 0.9 + 0.1 * double(rank) / double(this->Count);
      KDSTREAM_TRY(this->Exec.Report("octree", done));
    }
    AddBoxesAbove(result.boxes);
    return {};
  }

  SpillFolder& Folder;
  SpillFile& Points;
  std::uint64_t Count;
  const KdTreeOptions& Options;
  std::uint64_t Memory;
  const Execution& Exec;
  double Searched = 0; // of the progress so far
  std::uint64_t RecordsRead = 0;
};

}

template <class Scalar>
Result<ExternalPartitions> PartitionByExternalOctree(SpillFolder& folder, SpillFile& points,
  const KdTreeOptions& options, std::uint64_t memory, const Execution& execution)
{
  return Partitioning<Scalar>(folder, points, options, memory, execution).Make();
}

template Result<ExternalPartitions> PartitionByExternalOctree<float>(
  SpillFolder&, SpillFile&, const KdTreeOptions&, std::uint64_t, const Execution&);
template Result<ExternalPartitions> PartitionByExternalOctree<double>(
  SpillFolder&, SpillFile&, const KdTreeOptions&, std::uint64_t, const Execution&);

std::vector<VertexId> JoinIntoBlocks(std::span<const VertexId> partitionBegin, std::uint64_t most)
{
  std::vector<VertexId> begin{ partitionBegin.front() };
  for (std::size_t p = 1; p < partitionBegin.size(); ++p)
  {
    // The block ends before the partition that would make the block too large.
    if (partitionBegin[p] - begin.back() > most && partitionBegin[p - 1] > begin.back())
    {
      begin.push_back(partitionBegin[p - 1]);
    }
  }
  begin.push_back(partitionBegin.back());
  return begin;
}

}
