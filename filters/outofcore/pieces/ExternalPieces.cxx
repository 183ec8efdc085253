// SPDX-License-Identifier: BSD-3-Clause
// Parts of the resolutions, one after the other: see ExternalPieces.h.
#include "filters/outofcore/pieces/ExternalPieces.h"

#include "filters/core/RadixSort.h"
#include "filters/core/pieces/VertexNumbers.h"
#include "filters/outofcore/files/LoadAhead.h"
#include "filters/outofcore/files/ScatteredRead.h"
#include "filters/outofcore/pieces/ClusterLinks.h"
#include "filters/outofcore/pieces/CoarseNumbers.h"
#include "filters/outofcore/pieces/CoarseTree.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// The attribute arrays of the clusters of a block.
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
  KDSTREAM_TRY(ReadBlockElements(file, tupleBytes, block, tuples));
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

// A block of a level without parents, as OrderLevel takes it; the block's triangles are moved into
// it.
Result<ClusterLevel> ReadBlockLevel(
  const LevelFile& file, std::span<const AttributeInfo> attributes, LevelBlock& block)
{
  ClusterLevel level;
  Result<std::vector<Attribute>> arrays = ReadBlockTuples(file.tuples, attributes, block);
  KDSTREAM_TRY(arrays);
  level.attributes = std::move(*arrays);
  const Result<std::vector<ClusterRecord>> clusters =
    ReadBlockRecords<ClusterRecord>(file.clusters, block);
  KDSTREAM_TRY(clusters);
  level.positions.reserve(clusters->size());
  level.geometricErrors.reserve(clusters->size());
  for (const ClusterRecord& cluster : *clusters)
  {
    level.positions.push_back(cluster.position);
    level.geometricErrors.push_back(cluster.geometricError);
  }
  level.triangles = std::move(block.triangles);
  return level;
}

class PartWalk
{
public:
  PartWalk(const MeshBlocks& mesh, const ExternalLevels& levels, const ExternalNumbers& numbers,
    const PartVisit& visit, const Execution& execution, BlockGroup* group,
    const std::function<Status(Resolution)>& finished)
    : Input(mesh)
    , Levels(levels)
    , Numbers(numbers)
    , Visit(visit)
    , Exec(execution)
    , Group(group ? *group : this->Alone)
    , Finished(finished)
    , Coarse(mesh, levels, numbers)
  {
  }

  Status Walk()
  {
    KDSTREAM_TRY(this->Coarse.Load(this->Group));
    this->Tree.depths = this->Input.depths;
    this->Tree.partitionBegin = PartitionsOfCell(this->Input, 0, 0);
    this->Tree.levels = this->Coarse.Whole();
    this->Tree.levels.resize(this->Input.depths.finest + std::size_t{ 1 });
    const TreeDepths& depths = this->Input.depths;
    for (unsigned d = 0; d <= depths.finest; ++d)
    {
      KDSTREAM_TRY(d >= this->Levels.firstInFiles ? this->VisitBlocks(d)
                   : this->Group.IsFirst()        ? this->VisitWhole(d)
                                                  : Status{});
      KDSTREAM_TRY(this->Finish(Resolution::Level(d)));
    }
    KDSTREAM_TRY(this->VisitOriginal());
    return this->Finish(Resolution::Original());
  }

  Status WalkPartitions(std::span<const VertexId> partitionBegin)
  {
    this->Tree.depths = this->Input.depths;
    // Nodes after the last partition are empty.
    this->Tree.partitionBegin.assign(
      (std::size_t{ 1 } << this->Input.depths.partition) + 1, this->Input.vertexCount);
    std::copy(partitionBegin.begin(), partitionBegin.end(), this->Tree.partitionBegin.begin());
    return this->VisitOriginal();
  }

private:
  // Visits the pieces of cell `block` of `depth`.
  Status VisitPart(Resolution resolution, unsigned depth, std::size_t block, const Mesh& mesh) const
  {
    return this->Visit(this->Tree, mesh, resolution,
      PartOfCell(resolution, this->Input.depths, depth, block, this->Primitive()));
  }

  PrimitiveType Primitive() const
  {
    return this->Input.triangleCount == 0 ? PrimitiveType::Points : PrimitiveType::Triangles;
  }

  // The part that consists of the partitions of a block of the mesh.
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

  // Visits a level above those in files. Afterwards only its links are kept.
  Status VisitWhole(unsigned depth)
  {
    VertexTreeLevel& level = this->Tree.levels[depth];
    VertexTreeLevel links = level;
    level =
      OrderLevel(this->Levels.coarse[depth], this->Coarse.First()[depth], {}, this->Exec).level;
    level.parents = links.parents;
    level.childNodes = links.childNodes;
    KDSTREAM_TRY(this->VisitPart(Resolution::Level(depth), 0, 0, {}));
    level = std::move(links);
    return {};
  }

  // A part of a level in files, and its ancestors in the levels in files up to S, [depth].
  struct LevelPart
  {
    VertexTreeLevel level;
    std::vector<VertexTreeLevel> above;
  };

  // Visits a level in files.
  Status VisitBlocks(unsigned depth)
  {
    const LevelFile& file = this->Levels.files[depth];
    const BlockRange blocks = depth > this->Input.depths.stitch ? this->Group.Here(file.blockDepth)
                              : this->Group.IsFirst()           ? file.AllBlocks()
                                                                : BlockRange{};
    std::size_t block = blocks.begin;
    return ForEachLoaded(
      blocks.end - blocks.begin,
      [&](std::size_t i) { return this->LoadPart(depth, blocks.begin + i); },
      [&](LevelPart& part) -> Status
      {
        this->SetAbove(part.above);
        this->Tree.levels[depth] = std::move(part.level);
        KDSTREAM_TRY(this->VisitPart(Resolution::Level(depth), file.blockDepth, block++, {}));
        this->Tree.levels[depth] = {};
        return {};
      },
      this->Exec);
  }

  // above: levels in files from R to S; empty if no ancestors are needed.
  void SetAbove(std::vector<VertexTreeLevel>& above)
  {
    for (std::size_t d = this->Levels.firstInFiles; d < above.size(); ++d)
    {
      this->Tree.levels[d] = std::move(above[d]);
    }
  }

  Result<LevelPart> LoadPart(unsigned depth, std::size_t index) const
  {
    const LevelFile& file = this->Levels.files[depth];
    Result<LevelBlock> block = LoadLevelBlock(file, index);
    KDSTREAM_TRY(block);
    const Result<std::vector<VertexId>> first =
      ReadBlockRecords<VertexId>(this->Numbers.first[depth], *block);
    KDSTREAM_TRY(first);
    Result<ClusterLevel> level = ReadBlockLevel(file, this->Levels.attributes, *block);
    KDSTREAM_TRY(level);
    OrderedLevel ordered = OrderLevel(std::move(*level), *first, {}, this->Exec);
    LevelPart part;
    part.level = std::move(ordered.level);
    if (depth < this->Input.depths.stitch)
    {
      KDSTREAM_TRY(this->LoadChildNodes(depth, index, *block, ordered.places, part.level));
      KDSTREAM_TRY(this->LoadRanks(depth, *block, part));
      return part;
    }
    const CellRange own = RangeOfCell(this->Input.vertexCount, file.blockDepth, index);
    Result<std::vector<VertexTreeLevel>> above =
      this->Coarse.AncestorsOf(own, Outside(part.level.first, own));
    KDSTREAM_TRY(above);
    part.above = std::move(*above);
    if (depth == this->Input.depths.stitch)
    {
      part.level.ranks = std::move(part.above.back().ranks);
      part.level.parents = std::move(part.above.back().parents);
    }
    return part;
  }

  // Fills in the ranks of a part of a level coarser than S, and its ancestors.
  Status LoadRanks(unsigned depth, const LevelBlock& block, LevelPart& part) const
  {
    Result<std::vector<VertexId>> ranks =
      ReadBlockRecords<VertexId>(this->Numbers.ranks[depth], block);
    KDSTREAM_TRY(ranks);
    std::sort(ranks->begin(), ranks->end());
    part.level.ranks = std::move(*ranks);
    if (depth > PreviewLevel(this->Input.depths))
    {
      Result<std::vector<VertexTreeLevel>> above =
        this->Coarse.AncestorsOfRanks(depth, part.level.ranks);
      KDSTREAM_TRY(above);
      part.above = std::move(*above);
      part.level.parents = std::move(part.above.back().parents);
    }
    return {};
  }

  // places: those of the clusters of the block.
  Status LoadChildNodes(unsigned depth, std::size_t index, const LevelBlock& block,
    std::span<const VertexId> places, VertexTreeLevel& level) const
  {
    if (!HasChildNodes(Resolution::Level(depth), this->Input.depths))
    {
      return {};
    }
    const ChildNodeFile& file = this->Numbers.childNodes[depth];
    Result<std::vector<ChildNode>> childNodes =
      ReadInterval<ChildNode>(file.nodes, file.begin[index], file.begin[index + 1]);
    KDSTREAM_TRY(childNodes);
    const VertexId first = this->Levels.files[depth].begin[index];
    for (ChildNode& entry : *childNodes)
    {
      entry.cluster = places[block.ownBegin + (entry.cluster - first)];
    }
    std::sort(childNodes->begin(), childNodes->end());
    level.childNodes = std::move(*childNodes);
    return {};
  }

  // The numbers that are not in a range.
  static std::vector<VertexId> Outside(std::span<const VertexId> numbers, const CellRange& range)
  {
    std::vector<VertexId> outside;
    std::copy_if(numbers.begin(), numbers.end(), std::back_inserter(outside),
      [&](VertexId number) { return number < range.begin || number - range.begin >= range.size; });
    return outside;
  }

  Status VisitOriginal()
  {
    const BlockRange here = this->Input.begin.empty() ? this->Group.Here(this->Input.blockDepth)
                                                      : BlockRange{ 0, this->Input.BlockCount() };
    struct Part
    {
      TreeBlock block;
      std::vector<VertexId> numbers;
      std::vector<VertexTreeLevel> above;
    };
    std::size_t index = here.begin;
    return ForEachLoaded(
      here.end - here.begin,
      [&](std::size_t i) -> Result<Part>
      {
        Result<TreeBlock> block = this->Input.Load(here.begin + i, BlockOrder::ByRank);
        KDSTREAM_TRY(block);
        Result<std::vector<VertexId>> numbers = this->NumbersOf(block->ranks);
        KDSTREAM_TRY(numbers);
        Result<std::vector<VertexTreeLevel>> above =
          this->AncestorsOf(this->Input.RangeOf(here.begin + i), *numbers);
        KDSTREAM_TRY(above);
        return Part{ std::move(*block), std::move(*numbers), std::move(*above) };
      },
      [&](Part& part)
      {
        this->SetAbove(part.above);
        NumberPart(this->Tree, part.numbers);
        return this->Visit(
          this->Tree, part.block.mesh, Resolution::Original(), this->PartOfBlock(index++));
      },
      this->Exec);
  }

  // The ancestors of a block's own vertices and of its ghosts. numbers: in any order.
  Result<std::vector<VertexTreeLevel>> AncestorsOf(
    const CellRange& own, std::span<const VertexId> numbers) const
  {
    if (!this->Numbers.numberOfRank.IsOpen())
    {
      return std::vector<VertexTreeLevel>{}; // no levels
    }
    std::vector<VertexId> ghosts = Outside(numbers, own);
    std::sort(ghosts.begin(), ghosts.end());
    return this->Coarse.AncestorsOf(own, ghosts);
  }

  // The numbers of the vertices with these ranks. Ranks may be in any order; it is fastest if most
  // ascend.
  Result<std::vector<VertexId>> NumbersOf(std::span<const VertexId> ranks) const
  {
    if (!this->Numbers.numberOfRank.IsOpen())
    {
      return std::vector<VertexId>(ranks.begin(), ranks.end());
    }
    std::vector<std::uint64_t> sorted; // rank, index in `ranks`
    sorted.reserve(ranks.size());
    for (const VertexId rank : ranks)
    {
      sorted.push_back(std::uint64_t{ rank } << 32 | sorted.size());
    }
    SortByUpperHalf(sorted);
    std::vector<VertexId> ascending(ranks.size()), numbers(ranks.size());
    std::transform(sorted.begin(), sorted.end(), ascending.begin(),
      [](std::uint64_t entry) { return static_cast<VertexId>(entry >> 32); });
    KDSTREAM_TRY(
      ReadRecordsAt<VertexId>(this->Numbers.numberOfRank, ascending, std::span<VertexId>(numbers)));
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
  BlockGroup Alone;
  BlockGroup& Group;
  const std::function<Status(Resolution)>& Finished;
  CoarseTree Coarse;
  VertexTree Tree;
};

}

Status ForEachPart(const MeshBlocks& mesh, const ExternalLevels& levels,
  const ExternalNumbers& numbers, const PartVisit& visit, const Execution& execution,
  BlockGroup* group, const std::function<Status(Resolution)>& finished)
{
  return PartWalk(mesh, levels, numbers, visit, execution, group, finished).Walk();
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
