// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedImages.h"

#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/files/NumberSet.h"
#include "filters/outofcore/levels/LevelStates.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

class DistributedImages
{
public:
  DistributedImages(MpiGroup& group, SpillFolder& folder, const FinerTriangles& finer,
    std::uint64_t memory, LevelFile& level, bool byClusters)
    : Group(group)
    , Folder(folder)
    , Finer(finer)
    , Memory(memory)
    , Level(level)
    , ByClusters(byClusters)
    , Step(finer.blockDepth - level.blockDepth)
    , FinerHere(group.Here(finer.blockDepth))
    , Here(group.Here(level.blockDepth))
  {
  }

  Result<std::uint64_t> Write(LevelLinks* links)
  {
    KDSTREAM_TRY(this->SendOthers());
    ImageWriter writer(this->Folder, this->Level);
    KDSTREAM_TRY(writer.Begin(0));
    std::optional<LinkWriter> linkWriter;
    if (links != nullptr)
    {
      linkWriter.emplace(this->Level, *links);
      KDSTREAM_TRY(linkWriter->Begin(this->Folder));
    }
    for (std::size_t block = 0; block < this->Level.BlockCount(); ++block)
    {
      std::vector<Triangle> triangles;
      if (block >= this->Here.begin && block < this->Here.end)
      {
        KDSTREAM_TRY(this->LoadImages(block, triangles));
      }
      if (linkWriter)
      {
        KDSTREAM_TRY(linkWriter->Add(triangles));
      }
      KDSTREAM_TRY(writer.Add(triangles));
    }
    std::uint64_t count = writer.TriangleCount();
    KDSTREAM_TRY(this->Group.Sum(std::span(&count, 1)));
    return count;
  }

private:
  // Appends the images of the triangles of one of this rank's finer blocks.
  Status AddImages(std::size_t finer, std::vector<Triangle>& images) const
  {
    std::vector<Triangle> triangles;
    KDSTREAM_TRY(this->Finer.load(finer, triangles));
    KDSTREAM_TRY(MapCorners(
      triangles, this->Finer.map, this->Finer.begin[finer], this->Finer.begin[finer + 1]));
    images.insert(images.end(), triangles.begin(), triangles.end());
    return {};
  }

  // Loads all triangles that touch a block of the level: from finer blocks of this rank, and those
  // received from others.
  Status LoadImages(std::size_t block, std::vector<Triangle>& images) const
  {
    const std::size_t begin = std::max(this->FinerHere.begin, block << this->Step);
    const std::size_t end = std::min(this->FinerHere.end, (block + 1) << this->Step);
    for (std::size_t finer = begin; finer < end; ++finer)
    {
      KDSTREAM_TRY(this->AddImages(finer, images));
    }
    return this->Received->ForEach(block - this->Here.begin,
      [&](const Triangle& t) -> Status
      {
        images.push_back(t);
        return {};
      });
  }

  // Sends the images of the finer blocks that this rank has but whose level block is on another
  // rank.
  Status SendOthers()
  {
    std::vector<std::size_t> away; // finer blocks
    for (std::size_t finer = this->FinerHere.begin; finer < this->FinerHere.end; ++finer)
    {
      if (this->OwnerOf(finer >> this->Step) != this->Group.Rank())
      {
        away.push_back(finer);
      }
    }
    if (this->Here.begin < this->Here.end)
    {
      Result<RecordBuckets<Triangle>> buckets = RecordBuckets<Triangle>::Create(this->Folder,
        "triangles of other ranks", this->Here.end - this->Here.begin, 0, this->Memory / 8);
      KDSTREAM_TRY(buckets);
      this->Received.emplace(std::move(*buckets));
    }
    // While a triangle is being sent, its number is that of its block in the level.
    const auto make = [&](std::uint64_t round, RankLists<NumberedTriangle>& out)
    { return this->ListImages(away[static_cast<std::size_t>(round)], out); };
    const auto take = [&](std::size_t, std::span<const NumberedTriangle> triangles) -> Status
    {
      for (const NumberedTriangle& t : triangles)
      {
        KDSTREAM_TRY(this->Received->Add(t.number - this->Here.begin, t.corners));
      }
      return {};
    };
    KDSTREAM_TRY(this->Group.ExchangeInRounds<NumberedTriangle>(away.size(), make, take));
    return this->Received ? this->Received->Finish() : Status{};
  }

  Status ListImages(std::size_t finer, RankLists<NumberedTriangle>& out) const
  {
    const std::size_t block = finer >> this->Step;
    std::vector<NumberedTriangle>& list = out[this->OwnerOf(block)];
    std::vector<Triangle> triangles;
    KDSTREAM_TRY(this->AddImages(finer, triangles));
    for (const Triangle& t : triangles)
    {
      if (!IsDegenerate(t) || (this->ByClusters && (t[0] != t[1] || t[1] != t[2])))
      {
        list.push_back({ t, static_cast<std::uint32_t>(block) });
      }
    }
    return {};
  }

  std::size_t OwnerOf(std::size_t block) const
  {
    return this->Group.OwnerOf(block, this->Level.blockDepth);
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const FinerTriangles& Finer;
  const std::uint64_t Memory;
  LevelFile& Level;
  const bool ByClusters;
  const unsigned Step; // by how many depths the finer blocks are deeper
  const BlockRange FinerHere, Here;
  std::optional<RecordBuckets<Triangle>> Received; // by block; nothing if this rank has no blocks
};

}

Result<std::uint64_t> WriteDistributedImages(MpiGroup& group, SpillFolder& folder,
  const FinerTriangles& finer, std::uint64_t memory, LevelFile& level, LevelLinks* links)
{
  return DistributedImages(group, folder, finer, memory, level, links != nullptr).Write(links);
}

Status FetchForeignClusters(
  MpiGroup& group, std::size_t tupleBytes, LevelFile& level, const LevelLinks* links)
{
  const BlockRange here = group.Here(level.blockDepth);
  const VertexId ownBegin = level.begin[here.begin], ownEnd = level.begin[here.end];
  NumberSet<VertexId> foreign;
  const auto add = [&](VertexId c)
  {
    if (c < ownBegin || c >= ownEnd)
    {
      foreign.Add(c);
    }
  };
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<LevelBlock> loaded = LoadLevelBlock(level, block);
    KDSTREAM_TRY(loaded);
    const std::vector<VertexId> ghosts = loaded->Ghosts();
    std::for_each(ghosts.begin(), ghosts.end(), add);
    std::vector<Triangle> some;
    if (links != nullptr)
    {
      KDSTREAM_TRY(links->Load(block, block + 1, some));
    }
    for (const Triangle& link : some)
    {
      std::for_each(link.begin(), link.end(), add);
    }
  }
  level.foreign = foreign.Take();
  KDSTREAM_TRY(group.Fetch(
    level.clusters, sizeof(ClusterRecord), level.begin, level.blockDepth, level.foreign));
  return tupleBytes == 0
           ? Status{}
           : group.Fetch(level.tuples, tupleBytes, level.begin, level.blockDepth, level.foreign);
}

}
