// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/BlobList.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/tree/Region.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <variant>

namespace kdstream
{

namespace
{

using protocol::BlobId;
using protocol::BlobKind;

Error NoBlob(const ModelDescription& model, const BlobId& blob)
{
  return Error{ ErrorCode::NotFound, model.id + " has no " + protocol::BlobName(blob) };
}

// About the bytes of `count` pieces of a resolution.
std::uint64_t Estimate(const ResolutionDescription& resolution, std::uint64_t count)
{
  if (resolution.pieces == 0)
  {
    return 0;
  }
  const double mean =
    static_cast<double>(resolution.bytes) / static_cast<double>(resolution.pieces);
  constexpr double most = 9e15; // what JSON carries exactly
  return static_cast<std::uint64_t>(std::min(mean * static_cast<double>(count), most));
}

Result<BlobList> ListLevel(
  const ModelDescription& model, unsigned level, const std::vector<std::uint32_t>& nodes)
{
  const unsigned depth = PieceDepth(Resolution::Level(level), model.depths);
  BlobList list;
  list.kind = BlobKind::Level;
  list.level = static_cast<std::uint8_t>(level);
  list.numbers = nodes;
  list.first = std::uint32_t{ 1 } << depth;
  list.count = nodes.empty() ? list.first : nodes.size();
  if (level >= model.levels.size())
  {
    return NoBlob(model, list.At(0));
  }
  for (const auto node : nodes)
  {
    if (DepthOfNode(node) != depth)
    {
      return NoBlob(model, BlobId::LevelPiece(list.level, node));
    }
  }
  list.estimatedBytes = Estimate(model.levels[level], list.count);
  return list;
}

Result<BlobList> ListPartitions(
  const ModelDescription& model, const std::vector<std::uint32_t>& partitions)
{
  BlobList list;
  list.kind = BlobKind::Partition;
  list.numbers = partitions;
  list.count = partitions.size();
  for (const auto partition : partitions)
  {
    if (partition >= model.partitions)
    {
      return NoBlob(model, BlobId::Partition(partition));
    }
  }
  list.estimatedBytes = Estimate(model.original, list.count);
  return list;
}

// The texture of a partition.
Result<BlobList> ListTexture(const ModelDescription& model, std::uint32_t partition)
{
  BlobList list;
  list.kind = BlobKind::Texture;
  list.numbers = { partition };
  list.count = 1;
  if (!model.textures || partition >= model.partitions)
  {
    return NoBlob(model, BlobId::Texture(partition));
  }
  list.estimatedBytes = model.textures->bytes / model.partitions;
  return list;
}

// Pages of the tree, or boxes of partitions.
Result<BlobList> ListNodes(
  const ModelDescription& model, BlobKind kind, const std::vector<std::uint32_t>& nodes)
{
  BlobList list;
  list.kind = kind;
  list.numbers = nodes;
  list.count = nodes.size();
  for (const auto node : nodes)
  {
    const bool tree = kind == BlobKind::Tree;
    if (tree ? !IsTreePage(node, model.depths) : !HasPartitionBoxes(node, model.depths))
    {
      return NoBlob(model, { kind, 0, node });
    }
    const unsigned below = tree ? DepthsOfTreePage(node, model.depths)
                                : model.depths.partition - DepthOfPartitionBoxes(model.depths);
    const std::uint64_t bytesOfNode = tree ? 4 : 16; // as measured
    list.estimatedBytes += bytesOfNode << (below + (tree ? 1 : 0));
  }
  return list;
}

// Those of one blob, one after the other.
Result<BlobList> ListAnyBlobs(const ModelDescription& model, const std::vector<BlobId>& blobs)
{
  BlobList list;
  for (const BlobId& blob : blobs)
  {
    const auto one = blob.kind == BlobKind::Level ? ListLevel(model, blob.level, { blob.number })
                     : blob.kind == BlobKind::Partition ? ListPartitions(model, { blob.number })
                     : blob.kind == BlobKind::Texture
                       ? ListTexture(model, blob.number)
                       : ListNodes(model, blob.kind, { blob.number });
    KDSTREAM_TRY(one);
    list.estimatedBytes += one->estimatedBytes;
  }
  list.blobs = blobs;
  list.count = blobs.size();
  return list;
}

Result<BlobList> ListRegion(
  const ServedModel& model, const protocol::RegionRequest& request, std::size_t mostPartitions)
{
  const ModelDescription& description = model.Description();
  if (DepthOfNode(request.cell) > description.depths.partition)
  {
    return Error{ ErrorCode::InvalidArgument, "cell " + std::to_string(request.cell) +
                                                " is deeper than the partitions of " +
                                                description.id };
  }
  const auto boxes = model.Boxes();
  KDSTREAM_TRY(boxes);
  auto region = FindRegion(*boxes, description.depths, request.cell, request.rings, mostPartitions);
  if (!region && region.GetError().code == ErrorCode::LimitExceeded)
  {
    return Error{ ErrorCode::InvalidArgument, region.GetError().message };
  }
  KDSTREAM_TRY(region);

  auto held = request.except;
  std::sort(held.begin(), held.end());
  std::vector<std::uint32_t> wanted;
  std::copy_if(region->begin(), region->end(), std::back_inserter(wanted),
    [&](std::uint32_t partition)
    { return !std::binary_search(held.begin(), held.end(), partition); });

  auto list = ListPartitions(description, wanted);
  if (list && region->size() <= protocol::maximumListedPartitions)
  {
    list->region = std::move(*region);
  }
  return list;
}

}

BlobId BlobList::At(std::uint64_t index) const
{
  if (!this->blobs.empty())
  {
    return this->blobs[static_cast<std::size_t>(index)];
  }
  const auto number = this->numbers.empty() ? this->first + static_cast<std::uint32_t>(index)
                                            : this->numbers[static_cast<std::size_t>(index)];
  return { this->kind, this->level, number };
}

Result<BlobList> ListBlobs(
  const ServedModel& model, const protocol::ClientMessage& message, std::size_t mostPartitions)
{
  const ModelDescription& description = model.Description();
  if (const auto* level = std::get_if<protocol::LevelRequest>(&message.body))
  {
    return ListLevel(description, level->level, level->nodes);
  }
  if (const auto* tree = std::get_if<protocol::TreeRequest>(&message.body))
  {
    return ListNodes(description, BlobKind::Tree, tree->nodes);
  }
  if (const auto* boxes = std::get_if<protocol::BoxesRequest>(&message.body))
  {
    return ListNodes(description, BlobKind::Boxes, boxes->nodes);
  }
  if (const auto* region = std::get_if<protocol::RegionRequest>(&message.body))
  {
    return ListRegion(model, *region, mostPartitions);
  }
  if (const auto* partitions = std::get_if<protocol::PartitionsRequest>(&message.body))
  {
    return ListPartitions(description, partitions->partitions);
  }
  if (const auto* blobs = std::get_if<protocol::BlobsRequest>(&message.body))
  {
    return ListAnyBlobs(description, blobs->blobs);
  }
  return ListLevel(description, PreviewLevel(description), {});
}

}
