// SPDX-License-Identifier: BSD-3-Clause
// Keeps which requests are in flight, and which of their blobs are outstanding: step "request" of
// the pipeline picture.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace kdstream
{

// Every blob is outstanding in at most one request. All functions O(log blobs), unless stated
// otherwise.
class RequestBook
{
public:
  // Gives the request the next id, which is returned, and records its blobs as outstanding.
  // REQUIRES: none of them is outstanding already.
  std::uint32_t Send(SessionRequest request);
  // Cancels each request with an outstanding blob that is not in `wanted`; none of its blobs are
  // outstanding any more. `Open` is not cancelled by this. O(outstanding blobs).
  void CancelUnwanted(const std::set<protocol::BlobId>& wanted);
  // Cancels each request with outstanding blobs if none of them is in `wanted`; never `Open`. So
  // blobs of the other requests are not requested twice. O(outstanding blobs).
  void CancelUseless(const std::set<protocol::BlobId>& wanted);
  // Cancels everything. The numbering of requests continues.
  void CancelAll();

  // An answer has arrived. False if the request has no such blob outstanding, because it was
  // cancelled or never sent.
  bool Settle(std::uint32_t request, const protocol::BlobId& blob);
  bool SettleOpen(std::uint32_t request);
  // An answer has arrived for a request that was cancelled after it had been sent: true if the
  // request has this blob outstanding, the first time. Only for the last cancelledRequests
  // requests, and not for those before CancelAll.
  bool TakeLate(std::uint32_t request, const protocol::BlobId& blob);
  static constexpr std::size_t cancelledRequests = 64;
  // The request is over. Returns what is still outstanding of it; nothing if the request is not
  // known (any more).
  std::vector<protocol::BlobId> Close(std::uint32_t request);

  // The outstanding blobs, and their requests.
  const std::map<protocol::BlobId, std::uint32_t>& AllOutstanding() const
  {
    return this->Outstanding;
  }
  std::size_t RequestCount() const { return this->Open.size(); }
  bool IsOutstanding(const protocol::BlobId& blob) const
  {
    return this->Outstanding.count(blob) != 0;
  }
  const SessionRequest* Find(std::uint32_t request) const;
  bool Empty() const { return this->Open.empty(); }
  // A list of what is outstanding for messages: "open dragon, levels/12/3, and 4 more".
  std::string Describe() const;

  // The requests to send since the last TakeOutgoing, in order.
  const std::vector<SessionRequest>& Outgoing() const { return this->Unsent; }
  std::vector<SessionRequest> TakeOutgoing();

private:
  void Cancel(std::uint32_t request);
  // Cancels the requests for which `cancels` is true. outstanding: how many of their blobs are
  // outstanding; useful: how many of these are in `wanted`.
  void CancelWhere(const std::set<protocol::BlobId>& wanted,
    bool (*cancels)(std::size_t useful, std::size_t outstanding));

  std::uint32_t LastId = 0;
  struct Entry
  {
    SessionRequest request;
    std::set<protocol::BlobId> outstanding;
  };
  std::map<std::uint32_t, Entry> Open;
  std::map<protocol::BlobId, std::uint32_t> Outstanding;
  std::vector<SessionRequest> Unsent;
  std::map<std::uint32_t, Entry> Cancelled; // those that had been sent
};

}
