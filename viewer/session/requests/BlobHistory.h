// SPDX-License-Identifier: BSD-3-Clause
// A history of the newest blobs of a session: how each arrived, how long it took to decode, and how
// long the frame took that first showed it. Also how many of the bytes were not used.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <vector>

namespace kdstream
{

// All O(log pieces) a blob.
class BlobHistory
{
public:
  // Keeps the newest `most` blobs.
  explicit BlobHistory(std::size_t most);

  // A blob of `bytes` bytes has arrived, of any kind; isWasted: nobody waited for it.
  void Count(std::size_t bytes, bool isWasted);
  // A piece has been decoded; `entry` says how its blob arrived.
  void Add(PieceId piece, BlobStatistics entry);
  // A late blob was counted as wasted, but its piece may still be shown.
  void AddLate(PieceId piece, std::size_t bytes) { this->NeverShown[piece] += bytes; }
  // A frame has begun that shows these pieces. The pieces that are shown for the first time share
  // the frame's time.
  void BeginFrame(const std::set<PieceId>& shown);
  void EndFrame(double seconds);
  // Another model is opened: pieces of the last one that were never shown stay wasted.
  void CloseModel();

  const std::deque<BlobStatistics>& Entries() const { return this->Newest; } // oldest first
  const SessionTraffic& Traffic() const { return this->Sum; }

private:
  // Entries are numbered from the first one of the session; null if it has been forgotten.
  BlobStatistics* Find(std::uint64_t number);

  std::size_t Most;
  std::deque<BlobStatistics> Newest;
  std::uint64_t Forgotten = 0;               // number of the first in Newest
  std::map<PieceId, std::uint64_t> NotShown; // the number of its entry
  std::vector<std::uint64_t> JustShown;      // by the frame that has begun
  SessionTraffic Sum;
  // Bytes of pieces that have not been shown: they count as wasted until they are shown.
  std::map<PieceId, std::size_t> NeverShown;
};

}
