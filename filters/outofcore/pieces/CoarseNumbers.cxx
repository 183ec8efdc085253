// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the levels 0 … S: see CoarseNumbers.h, and VertexNumbers.h for the order of the
// computation.
#include "filters/outofcore/pieces/CoarseNumbers.h"

#include "filters/core/pieces/VertexNumbers.h"
#include "filters/outofcore/pieces/ClusterLinks.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace kdstream
{

std::vector<VertexId> PartitionsOfCell(const MeshBlocks& mesh, unsigned depth, std::size_t cell)
{
  const unsigned below = mesh.depths.partition - depth;
  std::vector<VertexId> begin;
  for (std::uint64_t p = std::uint64_t{ cell } << below; p < (std::uint64_t{ cell } + 1) << below;
       ++p)
  {
    begin.push_back(
      static_cast<VertexId>(RangeOfCell(mesh.vertexCount, mesh.depths.partition, p).begin));
  }
  const CellRange range = RangeOfCell(mesh.vertexCount, depth, cell);
  begin.push_back(static_cast<VertexId>(range.begin + range.size));
  return begin;
}

Result<std::vector<std::vector<VertexId>>> FirstAboveFiles(
  const ExternalLevels& levels, const ExternalNumbers& numbers)
{
  const unsigned inFiles = levels.firstInFiles;
  std::vector<std::vector<VertexId>> first(inFiles);
  for (unsigned d = 0; d < inFiles; ++d)
  {
    first[d].assign(levels.coarse[d].lowest.size(), noVertex);
  }
  const LevelFile& level = levels.files[inFiles];
  for (std::size_t block = 0; inFiles > 0 && block < level.BlockCount(); ++block)
  {
    const Result<ParentLinks> above = ReadParents(levels, inFiles, block);
    KDSTREAM_TRY(above);
    const Result<std::vector<VertexId>> ofBlock =
      ReadInterval<VertexId>(numbers.first[inFiles], level.begin[block], level.begin[block + 1]);
    KDSTREAM_TRY(ofBlock);
    LowerFirst(above->parents, *ofBlock,
      std::span(first[inFiles - 1]).subspan(above->begin, above->end - above->begin));
  }
  for (unsigned d = inFiles; d-- > 1;)
  {
    LowerFirst(levels.coarse[d].parents, first[d], first[d - 1]);
  }
  return first;
}

Result<std::vector<ChildNode>> ReadChildNodesOfParents(const ExternalLevels& levels,
  const ExternalNumbers& numbers, const VertexTree& tree, unsigned depth, std::size_t block)
{
  const Result<ParentLinks> above = ReadParents(levels, depth, block);
  KDSTREAM_TRY(above);
  const LevelFile& level = levels.files[depth];
  const Result<std::vector<VertexId>> first =
    ReadInterval<VertexId>(numbers.first[depth], level.begin[block], level.begin[block + 1]);
  KDSTREAM_TRY(first);
  std::vector<ChildNode> childNodes = ChildNodesOfParents(tree, depth, *first, above->parents);
  for (ChildNode& entry : childNodes)
  {
    entry.cluster += above->begin;
  }
  return childNodes;
}

VertexTree TreeOfPartitions(const MeshBlocks& mesh)
{
  VertexTree tree;
  tree.depths = mesh.depths;
  tree.partitionBegin = PartitionsOfCell(mesh, 0, 0);
  return tree;
}

namespace
{

// For each value its place in ascending order.
std::vector<VertexId> PlacesOf(std::span<const VertexId> values)
{
  const std::vector<VertexId> order = OrderByKey(values);
  std::vector<VertexId> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    places[order[i]] = static_cast<VertexId>(i);
  }
  return places;
}

// The values of the parents of a block: records of a file, or entries of `whole` if the parents are
// above the levels in files.
Result<std::vector<VertexId>> ValuesOfParents(
  const ParentLinks& links, const SpillFile* file, std::span<const VertexId> whole)
{
  if (file && file->IsOpen())
  {
    return ReadInterval<VertexId>(*file, links.begin, links.end);
  }
  const auto begin = whole.begin() + std::ptrdiff_t(links.begin);
  return std::vector<VertexId>(begin, begin + std::ptrdiff_t(links.end - links.begin));
}

class CoarseNumbering
{
public:
  CoarseNumbering(SpillFolder& folder, const MeshBlocks& mesh, const ExternalLevels& levels,
    ExternalNumbers& numbers)
    : Folder(folder)
    , Input(mesh)
    , Levels(levels)
    , Numbers(numbers)
    , Stitch(mesh.depths.stitch)
  {
  }

  Status Number()
  {
    const unsigned inFiles = this->Levels.firstInFiles;
    KDSTREAM_TRY(this->NumberStitch());
    for (unsigned d = this->Stitch; d > inFiles; --d)
    {
      KDSTREAM_TRY(this->NumberParents(d));
    }
    KDSTREAM_TRY(this->RankClusters());
    const VertexTree tree = TreeOfPartitions(this->Input);
    for (unsigned d = std::max(inFiles, PreviewLevel(tree.depths)); d < this->Stitch; ++d)
    {
      KDSTREAM_TRY(this->FindChildNodesOfParents(tree, d + 1));
    }
    return {};
  }

private:
  // Creates a file with `bytes` for each cluster of a level.
  Status Create(std::string_view purpose, unsigned depth, std::size_t bytes, SpillFile& file)
  {
    Result<SpillFile> made = this->Folder.CreateFile(
      purpose, std::uint64_t{ this->Levels.files[depth].ClusterCount() } * bytes);
    KDSTREAM_TRY(made);
    file = std::move(*made);
    return {};
  }

  // Calls work(block, first cluster, end) -> Status for each block of a level that has clusters.
  template <class Work>
  Status ForEachBlock(unsigned depth, const Work& work) const
  {
    const LevelFile& level = this->Levels.files[depth];
    for (std::size_t block = 0; block < level.BlockCount(); ++block)
    {
      if (level.begin[block] < level.begin[block + 1])
      {
        KDSTREAM_TRY(work(block, level.begin[block], level.begin[block + 1]));
      }
    }
    return {};
  }

  Status NumberStitch()
  {
    SpillFile& file = this->Numbers.first[this->Stitch];
    KDSTREAM_TRY(this->Create("numbers of a level", this->Stitch, sizeof(VertexId), file));
    const unsigned blockDepth = this->Levels.files[this->Stitch].blockDepth;
    return this->ForEachBlock(this->Stitch,
      [&](std::size_t block, VertexId begin, VertexId) -> Status
      {
        const Result<ClusterLinks> links = ReadLinks(this->Levels, this->Stitch, block);
        KDSTREAM_TRY(links);
        const std::vector<VertexId> first = FirstOfStitch(
          links->Links(), links->counts, PartitionsOfCell(this->Input, blockDepth, block));
        return WriteRecords<VertexId>(file, begin, std::span<const VertexId>(first));
      });
  }

  // Numbers level depth - 1 from level `depth`.
  Status NumberParents(unsigned depth)
  {
    SpillFile& file = this->Numbers.first[depth - 1];
    KDSTREAM_TRY(this->Create("numbers of a level", depth - 1, sizeof(VertexId), file));
    return this->ForEachBlock(depth,
      [&](std::size_t block, VertexId begin, VertexId end) -> Status
      {
        const Result<ParentLinks> above = ReadParents(this->Levels, depth, block);
        KDSTREAM_TRY(above);
        const Result<std::vector<VertexId>> first =
          ReadInterval<VertexId>(this->Numbers.first[depth], begin, end);
        KDSTREAM_TRY(first);
        std::vector<VertexId> ofParents(above->end - above->begin, noVertex);
        LowerFirst(above->parents, *first, ofParents);
        return WriteRecords<VertexId>(file, above->begin, std::span<const VertexId>(ofParents));
      });
  }

  Status RankClusters()
  {
    const unsigned inFiles = this->Levels.firstInFiles;
    std::vector<VertexId> whole; // of the coarsest level's parents, which are in memory
    if (inFiles > 0)
    {
      const Result<std::vector<std::vector<VertexId>>> first =
        FirstAboveFiles(this->Levels, this->Numbers);
      KDSTREAM_TRY(first);
      whole = PlacesOf(first->back());
    }
    for (unsigned d = inFiles; d <= this->Stitch; ++d)
    {
      SpillFile& ranks = this->Numbers.ranks[d];
      KDSTREAM_TRY(this->Create("ranks of clusters", d, sizeof(VertexId), ranks));
      KDSTREAM_TRY(
        this->Create("clusters by rank", d, sizeof(RankedCluster), this->Numbers.ranked[d]));
      KDSTREAM_TRY(this->ForEachBlock(d, [&](std::size_t block, VertexId begin, VertexId end)
        { return this->RankBlock(d, block, begin, end, whole); }));
    }
    return {};
  }

  // whole: the ranks in the finest level that is in memory.
  Status RankBlock(unsigned depth, std::size_t block, VertexId begin, VertexId end,
    std::span<const VertexId> whole)
  {
    const Result<ParentLinks> above = ReadParents(this->Levels, depth, block);
    KDSTREAM_TRY(above);
    const Result<std::vector<VertexId>> first =
      ReadInterval<VertexId>(this->Numbers.first[depth], begin, end);
    KDSTREAM_TRY(first);
    const Result<std::vector<VertexId>> ofParents =
      ValuesOfParents(*above, depth > 0 ? &this->Numbers.ranks[depth - 1] : nullptr, whole);
    KDSTREAM_TRY(ofParents);
    const std::vector<VertexId> order = OrderByKey(*first);
    std::vector<VertexId> ranks(order.size());
    std::vector<RankedCluster> ranked;
    ranked.reserve(order.size());
    for (const VertexId cluster : order)
    {
      ranks[cluster] = begin + static_cast<VertexId>(ranked.size());
      ranked.push_back(
        { (*first)[cluster], above->parents.empty() ? 0 : (*ofParents)[above->parents[cluster]] });
    }
    KDSTREAM_TRY(
      WriteRecords<VertexId>(this->Numbers.ranks[depth], begin, std::span<const VertexId>(ranks)));
    return WriteRecords<RankedCluster>(
      this->Numbers.ranked[depth], begin, std::span<const RankedCluster>(ranked));
  }

  // Finds the child nodes of level depth - 1 from level `depth`, whose blocks are the same or
  // smaller.
  Status FindChildNodesOfParents(const VertexTree& tree, unsigned depth)
  {
    ChildNodeFile& file = this->Numbers.childNodes[depth - 1];
    KDSTREAM_TRY(this->Create("nodes below clusters", depth - 1, sizeof(ChildNode), file.nodes));
    const std::size_t blocks = this->Levels.files[depth].BlockCount();
    const std::size_t step = blocks / this->Levels.files[depth - 1].BlockCount();
    std::uint64_t written = 0;
    for (std::size_t block = 0; block < blocks; ++block)
    {
      if (block % step == 0)
      {
        file.begin.push_back(written);
      }
      const Result<std::vector<ChildNode>> childNodes =
        ReadChildNodesOfParents(this->Levels, this->Numbers, tree, depth, block);
      KDSTREAM_TRY(childNodes);
      KDSTREAM_TRY(
        WriteRecords<ChildNode>(file.nodes, written, std::span<const ChildNode>(*childNodes)));
      written += childNodes->size();
    }
    file.begin.push_back(written);
    return {};
  }

  SpillFolder& Folder;
  const MeshBlocks& Input;
  const ExternalLevels& Levels;
  ExternalNumbers& Numbers;
  const unsigned Stitch;
};

// Copies a file of `count` numbers from the first process to all others.
Status SpreadFile(SpillFolder& folder, BlockGroup& group, std::uint64_t count, SpillFile& file)
{
  constexpr std::uint64_t atOnce = spillBlockBytes / sizeof(VertexId);
  if (!group.IsFirst())
  {
    Result<SpillFile> made =
      folder.CreateFile("numbers of the first process", count * sizeof(VertexId));
    KDSTREAM_TRY(made);
    file = std::move(*made);
  }
  for (std::uint64_t begin = 0; begin < count; begin += atOnce)
  {
    std::vector<VertexId> some;
    if (group.IsFirst())
    {
      some.resize(static_cast<std::size_t>(std::min(atOnce, count - begin)));
      KDSTREAM_TRY(ReadRecords<VertexId>(file, begin, std::span<VertexId>(some)));
    }
    KDSTREAM_TRY(group.Spread(some));
    if (!group.IsFirst())
    {
      KDSTREAM_TRY(WriteRecords<VertexId>(file, begin, std::span<const VertexId>(some)));
    }
  }
  return {};
}

}

Status NumberCoarseLevels(SpillFolder& folder, const MeshBlocks& mesh, const ExternalLevels& levels,
  ExternalNumbers& numbers, BlockGroup& group)
{
  const unsigned stitch = mesh.depths.stitch;
  numbers.ranks.resize(stitch + std::size_t{ 1 });
  numbers.ranked.resize(stitch + std::size_t{ 1 });
  numbers.childNodes.resize(stitch + std::size_t{ 1 });
  if (group.IsFirst())
  {
    KDSTREAM_TRY(CoarseNumbering(folder, mesh, levels, numbers).Number());
  }
  const auto spread = [&](SpillFile& file, unsigned depth, std::uint64_t numbersEach)
  {
    const std::uint64_t count = levels.files[depth].ClusterCount() * numbersEach;
    return SpreadFile(folder, group, count, file);
  };
  KDSTREAM_TRY(spread(numbers.first[stitch], stitch, 1));
  for (unsigned d = levels.firstInFiles; d <= stitch; ++d)
  {
    KDSTREAM_TRY(spread(numbers.ranked[d], d, sizeof(RankedCluster) / sizeof(VertexId)));
  }
  return {};
}

}
