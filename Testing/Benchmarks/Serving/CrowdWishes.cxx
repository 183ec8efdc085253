// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/Serving/CrowdWishes.h"

#include "filters/codec/TreePage.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/core/tree/Region.h"

#include <algorithm>
#include <utility>

namespace kdstream::benchmarks
{

using protocol::BlobId;

namespace
{

SessionRequest Blobs(std::vector<BlobId> blobs)
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  request.blobs = std::move(blobs);
  return request;
}

}

SessionRequest CrowdWishes::Preview() const
{
  const auto level = PreviewLevel(this->Model.description);
  return Blobs({ BlobId::LevelPiece(static_cast<std::uint8_t>(level), 1) });
}

SessionRequest CrowdWishes::Zoom()
{
  const auto& depths = this->Model.description.depths;
  const unsigned level = this->Below(depths.finest - depths.onePiece) + depths.onePiece;
  const auto pieces = this->LevelPieces(level), finer = this->LevelPieces(level + 1);
  const auto wanted = std::min<std::size_t>(pieces.size(), 4 + this->Below(5));
  const auto from = this->Below(static_cast<std::uint32_t>(pieces.size() - wanted + 1));
  const auto begin = pieces.begin() + from;
  std::vector<BlobId> blobs(begin, begin + static_cast<std::ptrdiff_t>(wanted));
  blobs.push_back(finer[from * finer.size() / pieces.size()]);
  return Blobs(std::move(blobs));
}

SessionRequest CrowdWishes::Tap()
{
  const auto& model = this->Model.description;
  const NodeId cell = (NodeId{ 1 } << model.depths.partition) +
                      this->Below(static_cast<std::uint32_t>(model.partitions));
  const auto found = FindRegion(this->Model.boxes, model.depths, cell, 1);
  std::vector<BlobId> wanted;
  std::set<std::uint32_t> had;
  for (const auto partition : found ? *found : std::vector<std::uint32_t>())
  {
    had.insert(partition);
    if (this->Held.count(partition) == 0)
    {
      wanted.push_back(BlobId::Partition(partition));
    }
  }
  if (wanted.empty())
  {
    return this->Zoom();
  }
  this->Held = std::move(had);
  return Blobs(std::move(wanted));
}

SessionRequest CrowdWishes::BrowseTree()
{
  const auto& depths = this->Model.description.depths;
  std::vector<BlobId> pages;
  for (unsigned depth = 0; depth < depths.partition; ++depth)
  {
    const auto first = NodeId{ 1 } << depth;
    const auto page = first + this->Below(first);
    if (IsTreePage(page, depths))
    {
      pages.push_back(BlobId::TreePage(page));
    }
  }
  return Blobs(std::move(pages));
}

SessionRequest CrowdWishes::FinestLevel() const
{
  return Blobs(this->LevelPieces(this->Model.description.depths.finest));
}

SessionRequest CrowdWishes::Partitions(std::uint64_t count) const
{
  std::vector<BlobId> partitions;
  const auto most = std::min(count, this->Model.description.partitions);
  for (std::uint32_t partition = 0; partition < most; ++partition)
  {
    partitions.push_back(BlobId::Partition(partition));
  }
  return Blobs(std::move(partitions));
}

std::vector<BlobId> CrowdWishes::LevelPieces(unsigned level) const
{
  const unsigned depth = PieceDepth(Resolution::Level(level), this->Model.description.depths);
  std::vector<BlobId> pieces;
  for (NodeId node = NodeId{ 1 } << depth; node < NodeId{ 2 } << depth; ++node)
  {
    pieces.push_back(BlobId::LevelPiece(static_cast<std::uint8_t>(level), node));
  }
  return pieces;
}

std::uint32_t CrowdWishes::Below(std::uint32_t end)
{
  return std::uniform_int_distribution<std::uint32_t>(0, std::max(end, 1u) - 1)(this->Chance);
}

double CrowdWishes::Uniform(double low, double high)
{
  return std::uniform_real_distribution<>(low, high)(this->Chance);
}

double CrowdWishes::Exponential(double mean)
{
  return std::exponential_distribution<>(1 / mean)(this->Chance);
}

}
