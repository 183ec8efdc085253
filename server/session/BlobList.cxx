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

constexpr std::uint64_t mostBytes = 9'000'000'000'000'000; // JSON holds numbers up to this exactly

// An estimate of the bytes of `count` pieces of a resolution.
std::uint64_t Estimate(const ResolutionDescription& resolution, std::uint64_t count)
{
  if (resolution.pieces == 0)
  {
    return 0;
  }
  const double mean =
    static_cast<double>(resolution.bytes) / static_cast<double>(resolution.pieces);
  return static_cast<std::uint64_t>(
    std::min(mean * static_cast<double>(count), static_cast<double>(mostBytes)));
}

// An estimate of the bytes of a blob. Errors: NotFound if the model does not have the blob.
Result<std::uint64_t> BytesOf(const ModelDescription& model, const BlobId& blob)
{
  const TreeDepths& depths = model.depths;
  switch (blob.kind)
  {
    case BlobKind::Level:
      if (blob.level < model.levels.size() &&
          DepthOfNode(blob.number) == PieceDepth(Resolution::Level(blob.level), depths))
      {
        return Estimate(model.levels[blob.level], 1);
      }
      break;
    case BlobKind::Partition:
      if (blob.number < model.partitions)
      {
        return Estimate(model.original, 1);
      }
      break;
    case BlobKind::Texture:
      if (model.textures && blob.number < model.partitions)
      {
        return model.textures->bytes / model.partitions;
      }
      break;
    case BlobKind::LevelTexture:
      if (model.textures && model.textures->levels && blob.level < model.levels.size() &&
          DepthOfNode(blob.number) == PieceDepth(Resolution::Level(blob.level), depths))
      {
        const ResolutionDescription& level = model.levels[blob.level];
        return level.tileBytes / std::max<std::uint64_t>(level.pieces, 1);
      }
      break;
    // As measured: 4 bytes for each node, 16 for each partition.
    case BlobKind::Tree:
      if (IsTreePage(blob.number, depths))
      {
        return std::uint64_t{ 4 } << (DepthsOfTreePage(blob.number, depths) + 1);
      }
      break;
    case BlobKind::Boxes:
      if (HasPartitionBoxes(blob.number, depths))
      {
        return std::uint64_t{ 16 } << (depths.partition - DepthOfPartitionBoxes(depths));
      }
      break;
  }
  return Error{ ErrorCode::NotFound, model.id + " has no " + protocol::BlobName(blob) };
}

Result<BlobList> ListNamed(const ModelDescription& model, const std::vector<BlobId>& blobs)
{
  BlobList list;
  for (const BlobId& blob : blobs)
  {
    const auto bytes = BytesOf(model, blob);
    KDSTREAM_TRY(bytes);
    list.estimatedBytes = std::min(list.estimatedBytes + *bytes, mostBytes);
  }
  list.blobs = blobs;
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
  BlobList list;
  for (const std::uint32_t partition : *region)
  {
    if (!std::binary_search(held.begin(), held.end(), partition))
    {
      list.blobs.push_back(BlobId::Partition(partition));
    }
  }
  list.estimatedBytes = Estimate(description.original, list.blobs.size());
  if (region->size() <= protocol::maximumListedPartitions)
  {
    list.region = std::move(*region);
  }
  return list;
}

}

Result<BlobList> ListBlobs(
  const ServedModel& model, const protocol::ClientMessage& message, std::size_t mostPartitions)
{
  const auto* const region = std::get_if<protocol::RegionRequest>(&message.body);
  return region
           ? ListRegion(model, *region, mostPartitions)
           : ListNamed(model.Description(), std::get<protocol::BlobsRequest>(message.body).blobs);
}

}
