// SPDX-License-Identifier: BSD-3-Clause
// Which requests are in flight, and which of their blobs are outstanding: step "request" of the
// pipeline picture.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace kdstream
{

// Every blob is outstanding in at most one request. All O(log blobs), but for what is said
// otherwise.
class RequestBook
{
public:
  // Gives the request the next id, which is returned, and notes what it will bring. REQUIRES: none
  // of its blobs is outstanding already.
  std::uint32_t Send(SessionRequest request);
  // Cancels each request with an outstanding blob that is not in `wanted`; its blobs are
  // outstanding nowhere then. `Open` is never cancelled so. O(outstanding blobs).
  void CancelUnwanted(const std::set<protocol::BlobId>& wanted);
  // Cancels each request with outstanding blobs of which none is in `wanted`, `Open` never. So what
  // comes of the others is not asked for twice. O(outstanding blobs).
  void CancelUseless(const std::set<protocol::BlobId>& wanted);
  // Cancels everything. Ids go on.
  void CancelAll();

  // An answer came: false if that request has no such blob outstanding (it was cancelled, or never
  // asked).
  bool Settle(std::uint32_t request, const protocol::BlobId& blob);
  bool SettleOpen(std::uint32_t request);
  // An answer came to a request that was cancelled after it had been sent: true if this
  // blob of it is outstanding, the first time. Only of the last cancelledRequests, and of none
  // before CancelAll.
  bool TakeLate(std::uint32_t request, const protocol::BlobId& blob);
  static constexpr std::size_t cancelledRequests = 64;
  // The request is over: what is still outstanding of it, nothing if it is not known (any more).
  std::vector<protocol::BlobId> Close(std::uint32_t request);

  // What is outstanding, and in which request.
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

  // What there is to send since the last TakeOutgoing, in order.
  const std::vector<SessionRequest>& Outgoing() const { return this->Unsent; }
  std::vector<SessionRequest> TakeOutgoing();

private:
  void Cancel(std::uint32_t request);
  // Those of which so many outstanding blobs are in `wanted`.
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
  std::map<std::uint32_t, Entry> Cancelled; // after they had been sent
};

}
