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

// Blobs in the order in which they are sent.
struct BlobList
{
  std::vector<protocol::BlobId> blobs;
  std::uint64_t estimatedBytes = 0;

  // A region's partitions, those left out too; absent if there are too many to list.
  std::optional<std::vector<std::uint32_t>> region;
};

// Errors: NotFound for a blob that the model does not have; InvalidArgument for a cell outside its
// tree, or a region of more than `mostPartitions`; Damaged if the tree cannot be read. REQUIRES: a
// request for blobs or a region.
Result<BlobList> ListBlobs(
  const ServedModel& model, const protocol::ClientMessage& message, std::size_t mostPartitions);

}
