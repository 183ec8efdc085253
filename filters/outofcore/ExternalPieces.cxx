// Parts of the resolutions, one after the other: see ExternalPieces.h.
#include "filters/outofcore/ExternalPieces.h"

#include "filters/core/RadixSort.h"
#include "filters/core/VertexNumbers.h"
#include "filters/outofcore/LoadAhead.h"
#include "filters/outofcore/ScatteredRead.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// The arrays of the clusters of a block.
Result<std::vector<Attribute>> ReadBlockTuples(
  const SpillFile& file, std::span<const AttributeInfo> attributes, const LevelBlock& block)
{
  std::vector<Attribute> arrays;
  std::size_t tupleBytes = 0;
  for (const AttributeInfo& attribute : attributes)
  {
    arrays.push_back({ attribute, {} });
    tupleBytes += attribute.TupleSize();
  }
  const std::size_t count = block.clusters.size();
  if (tupleBytes == 0 || count == 0)
  {
    return arrays;
  }
  std::vector<std::byte> tuples(count * tupleBytes);
  if (Status status = ReadBlockElements(file, tupleBytes, block, tuples); !status)
  {
    return status.GetError();
  }
  std::size_t offset = 0;
  for (Attribute& array : arrays)
  {
    const std::size_t bytes = array.TupleSize();
    array.values.resize(count * bytes);
    for (std::size_t i = 0; i < count; ++i)
    {
      std::memcpy(array.values.data() + i * bytes, tuples.data() + i * tupleBytes + offset, bytes);
    }
    offset += bytes;
  }
  return arrays;
}

// A block of a level as OrderLevel takes it without parents.
Result<ClusterLevel> ReadBlockLevel(
  const LevelFile& file, std::span<const AttributeInfo> attributes, LevelBlock block)
{
  ClusterLevel level;
  Result<std::vector<Attribute>> arrays = ReadBlockTuples(file.tuples, attributes, block);
  if (!arrays)
  {
    return arrays.GetError();
  }
  level.attributes = std::move(*arrays);
  const Result<std::vector<ClusterRecord>> clusters =
    ReadBlockRecords<ClusterRecord>(file.clusters, block);
  if (!clusters)
  {
    return clusters.GetError();
  }
  level.positions.reserve(clusters->size());
  level.deviations.reserve(clusters->size());
  for (const ClusterRecord& cluster : *clusters)
  {
    level.positions.push_back(cluster.position);
    level.deviations.push_back(cluster.deviation);
  }
  level.triangles = std::move(block.triangles);
  return level;
}

class PartWalk
{
public:
  PartWalk(const MeshBlocks& mesh, const ExternalLevels& levels, const ExternalNumbers& numbers,
    const PartVisit& visit, const Execution& execution, BlockTeam* team,
    const std::function<Status(Resolution)>& finished)
    : Input(mesh)
    , Levels(levels)
    , Numbers(numbers)
    , Visit(visit)
    , Exec(execution)
    , Team(team ? *team : this->Alone)
    , Finished(finished)
  {
  }

  Status Walk()
  {
    Result<CoarseNumbers> coarse = NumberCoarseLevels(this->Input, this->Levels, &this->Team);
    if (!coarse)
    {
      return coarse.GetError();
    }
    this->FirstOfCoarse = std::move(coarse->first);
    this->Tree = std::move(coarse->tree);
    const TreeDepths& depths = this->Input.depths;
    for (unsigned d = 0; d <= depths.finest; ++d)
    {
      Status status = d > depths.stitch      ? this->VisitBlocks(d)
                      : this->Team.IsFirst() ? this->VisitWhole(d)
                                             : Status{};
      status = status ? this->Finish(Resolution::Level(d)) : status;
      if (!status)
      {
        return status;
      }
    }
    const Status status = this->VisitOriginal();
    return status ? this->Finish(Resolution::Original()) : status;
  }

  Status WalkPartitions(std::span<const VertexId> partitionBegin)
  {
    this->Tree.depths = this->Input.depths;
    // Nodes behind the last partition are empty.
    this->Tree.partitionBegin.assign(
      (std::size_t{ 1 } << this->Input.depths.partition) + 1, this->Input.vertexCount);
    std::copy(partitionBegin.begin(), partitionBegin.end(), this->Tree.partitionBegin.begin());
    return this->VisitOriginal();
  }

private:
  // The pieces of cell `block` of `depth`.
  Status VisitPart(Resolution resolution, unsigned depth, std::size_t block, const Mesh& mesh) const
  {
    return this->Visit(this->Tree, mesh, resolution,
      PartOfCell(resolution, this->Input.depths, depth, block, this->Primitive()));
  }

  PrimitiveType Primitive() const
  {
    return this->Input.triangleCount == 0 ? PrimitiveType::Points : PrimitiveType::Triangles;
  }

  // The partitions of a block of the mesh.
  ModelPart PartOfBlock(std::size_t block) const
  {
    if (this->Input.begin.empty())
    {
      return PartOfCell(Resolution::Original(), this->Input.depths, this->Input.blockDepth, block,
        this->Primitive());
    }
    const std::vector<VertexId>& begins = this->Tree.partitionBegin;
    const auto partitionAt = [&](VertexId rank)
    {
      return static_cast<std::size_t>(
        std::lower_bound(begins.begin(), begins.end(), rank) - begins.begin());
    };
    const std::size_t first = partitionAt(this->Input.begin[block]);
    return { first, partitionAt(this->Input.begin[block + 1]) - first, this->Primitive() };
  }

  Status Finish(Resolution resolution) const
  {
    return this->Finished ? this->Finished(resolution) : Status{};
  }

  Result<ClusterLevel> LoadWhole(unsigned depth) const
  {
    if (depth < this->Levels.firstInFiles)
    {
      return this->Levels.coarse[depth];
    }
    const LevelFile& file = this->Levels.files[depth];
    Result<LevelBlock> whole = LoadWholeLevel(file);
    return whole ? ReadBlockLevel(file, this->Levels.attributes, std::move(*whole))
                 : whole.GetError();
  }

  // A level up to S. Its links stay, the rest goes.
  Status VisitWhole(unsigned depth)
  {
    Result<ClusterLevel> loaded = this->LoadWhole(depth);
    if (!loaded)
    {
      return loaded.GetError();
    }
    OrderedLevel ordered =
      OrderLevel(std::move(*loaded), this->FirstOfCoarse[depth], {}, this->Exec);
    this->FirstOfCoarse[depth] = {};
    VertexTreeLevel& level = this->Tree.levels[depth];
    ordered.level.parents = std::move(level.parents);
    level = std::move(ordered.level);
    const Status status = this->VisitPart(Resolution::Level(depth), 0, 0, {});
    VertexTreeLevel links;
    links.first = std::move(level.first);
    links.parents = std::move(level.parents);
    level = std::move(links);
    return status;
  }

  // A level finer than S.
  Status VisitBlocks(unsigned depth)
  {
    const LevelFile& file = this->Levels.files[depth];
    const BlockRange here = this->Team.Here(file.blockDepth);
    std::size_t block = here.begin;
    return ForEachLoaded(
      here.end - here.begin, [&](std::size_t i) { return this->LoadPart(depth, here.begin + i); },
      [&](VertexTreeLevel& part)
      {
        this->Tree.levels[depth] = std::move(part);
        const Status status =
          this->VisitPart(Resolution::Level(depth), file.blockDepth, block++, {});
        this->Tree.levels[depth] = {};
        return status;
      },
      this->Exec);
  }

  Result<VertexTreeLevel> LoadPart(unsigned depth, std::size_t index) const
  {
    const LevelFile& file = this->Levels.files[depth];
    Result<LevelBlock> block = LoadLevelBlock(file, index);
    if (!block)
    {
      return block.GetError();
    }
    const Result<std::vector<VertexId>> first =
      ReadBlockRecords<VertexId>(this->Numbers.first[depth], *block);
    if (!first)
    {
      return first.GetError();
    }
    Result<ClusterLevel> level = ReadBlockLevel(file, this->Levels.attributes, std::move(*block));
    return level ? OrderLevel(std::move(*level), *first, {}, this->Exec).level
                 : Result<VertexTreeLevel>(level.GetError());
  }

  Status VisitOriginal()
  {
    const BlockRange here = this->Input.begin.empty() ? this->Team.Here(this->Input.blockDepth)
                                                      : BlockRange{ 0, this->Input.BlockCount() };
    struct Part
    {
      TreeBlock block;
      std::vector<VertexId> numbers;
    };
    std::size_t index = here.begin;
    return ForEachLoaded(
      here.end - here.begin,
      [&](std::size_t i) -> Result<Part>
      {
        Result<TreeBlock> block = this->Input.Load(here.begin + i, BlockOrder::ByRank);
        if (!block)
        {
          return block.GetError();
        }
        Result<std::vector<VertexId>> numbers = this->NumbersOf(block->ranks);
        return numbers ? Result<Part>(Part{ std::move(*block), std::move(*numbers) })
                       : Result<Part>(numbers.GetError());
      },
      [&](const Part& part)
      {
        NumberPart(this->Tree, part.numbers);
        return this->Visit(
          this->Tree, part.block.mesh, Resolution::Original(), this->PartOfBlock(index++));
      },
      this->Exec);
  }

  // Of vertices with these ranks, in any order (but fastest where most of them ascend).
  Result<std::vector<VertexId>> NumbersOf(std::span<const VertexId> ranks) const
  {
    if (!this->Numbers.numberOfRank.IsOpen())
    {
      return std::vector<VertexId>(ranks.begin(), ranks.end());
    }
    std::vector<std::uint64_t> sorted; // rank, place in `ranks`
    sorted.reserve(ranks.size());
    for (const VertexId rank : ranks)
    {
      sorted.push_back(std::uint64_t{ rank } << 32 | sorted.size());
    }
    SortByUpperHalf(sorted);
    std::vector<VertexId> ascending(ranks.size()), numbers(ranks.size());
    std::transform(sorted.begin(), sorted.end(), ascending.begin(),
      [](std::uint64_t entry) { return static_cast<VertexId>(entry >> 32); });
    if (Status status = ReadRecordsAt<VertexId>(
          this->Numbers.numberOfRank, ascending, std::span<VertexId>(numbers));
        !status)
    {
      return status.GetError();
    }
    std::vector<VertexId> result(ranks.size());
    for (std::size_t i = 0; i < sorted.size(); ++i)
    {
      result[static_cast<VertexId>(sorted[i])] = numbers[i];
    }
    return result;
  }

  const MeshBlocks& Input;
  const ExternalLevels& Levels;
  const ExternalNumbers& Numbers;
  const PartVisit& Visit;
  const Execution& Exec;
  BlockTeam Alone;
  BlockTeam& Team;
  const std::function<Status(Resolution)>& Finished;
  std::vector<std::vector<VertexId>> FirstOfCoarse; // of the levels up to S that are still to come
  VertexTree Tree;
};

}

Status ForEachPart(const MeshBlocks& mesh, const ExternalLevels& levels,
  const ExternalNumbers& numbers, const PartVisit& visit, const Execution& execution,
  BlockTeam* team, const std::function<Status(Resolution)>& finished)
{
  return PartWalk(mesh, levels, numbers, visit, execution, team, finished).Walk();
}

Status ForEachPartOfPartitions(const MeshBlocks& mesh, std::span<const VertexId> partitionBegin,
  const PartVisit& visit, const Execution& execution)
{
  const ExternalLevels noLevels;
  const ExternalNumbers asRanked;
  return PartWalk(mesh, noLevels, asRanked, visit, execution, nullptr, {})
    .WalkPartitions(partitionBegin);
}

}
