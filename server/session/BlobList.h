// SPDX-License-Identifier: BSD-3-Clause
// Which blobs answer a request: the part of a conversation that knows the model and has no state.
#pragma once

#include "filters/core/Result.h"
#include "filters/protocol/ControlMessage.h"
#include "server/session/Catalog.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace kdstream
{

// Blobs in the order in which they are sent: those of any kind, or of one kind and level the listed
// numbers, or the `count` numbers from `first`.
struct BlobList
{
  std::vector<protocol::BlobId> blobs;
  protocol::BlobKind kind = protocol::BlobKind::Tree;
  std::uint8_t level = 0;
  std::vector<std::uint32_t> numbers;
  std::uint32_t first = 0;
  std::uint64_t count = 0;
  std::uint64_t estimatedBytes = 0;

  // Of a region: its partitions, those left out too; absent if there are too many to list.
  std::optional<std::vector<std::uint32_t>> region;

  // REQUIRES: index < count.
  protocol::BlobId At(std::uint64_t index) const;
};

// Errors: NotFound for a blob that the model does not have; InvalidArgument for a cell outside its
// tree, or a region of more than `mostPartitions`; Damaged where the tree cannot be read. REQUIRES:
// a request for blobs (neither open nor cancel).
Result<BlobList> ListBlobs(
  const ServedModel& model, const protocol::ClientMessage& message, std::size_t mostPartitions);

}
