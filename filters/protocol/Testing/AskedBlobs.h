// SPDX-License-Identifier: BSD-3-Clause
// Requests for blobs of one kind by their numbers, for tests.
#pragma once

#include "filters/protocol/ControlMessage.h"

#include <cstdint>
#include <vector>

namespace kdstream::protocol
{

inline BlobsRequest AskPartitions(const std::vector<std::uint32_t>& numbers)
{
  BlobsRequest asked;
  for (const std::uint32_t number : numbers)
  {
    asked.blobs.push_back(BlobId::Partition(number));
  }
  return asked;
}

// A request for pieces of a level. Every model with levels has piece 1 of level 0.
inline BlobsRequest AskPieces(std::uint8_t level, const std::vector<std::uint32_t>& nodes)
{
  BlobsRequest asked;
  for (const std::uint32_t node : nodes)
  {
    asked.blobs.push_back(BlobId::LevelPiece(level, node));
  }
  return asked;
}

}
