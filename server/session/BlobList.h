// SPDX-License-Identifier: BSD-3-Clause
// Lists the blobs that answer a request: the part of a conversation that knows the model and has no
// state.
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

  // The partitions of a region, including those that the client has left out; absent if there are
  // too many to list.
  std::optional<std::vector<std::uint32_t>> region;
};

// Errors: NotFound for a blob that the model does not have; InvalidArgument for a cell outside its
// tree, or a region of more than `mostPartitions`; Damaged if the tree cannot be read. REQUIRES:
// the message is a request for blobs or for a region.
Result<BlobList> ListBlobs(
  const ServedModel& model, const protocol::ClientMessage& message, std::size_t mostPartitions);

}
