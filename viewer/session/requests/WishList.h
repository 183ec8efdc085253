// SPDX-License-Identifier: BSD-3-Clause
// The list of wanted blobs that are not loaded, most urgent first. Requests as many as fill the
// connection, and more as they arrive. Step "request" of the pipeline picture.
#pragma once

#include "viewer/session/SessionTypes.h"
#include "viewer/session/requests/BandwidthMeter.h"
#include "viewer/session/requests/RequestBook.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Each request has about a quarter of what may be in flight, so cancelling one wastes little. When
// everything on the list has arrived, what will probably be wanted next is prefetched; prefetches
// make way for what is wanted. O(log blobs) a blob, except functions that go through the whole
// list.
class WishList
{
public:
  // The approximate bytes of a blob that has not arrived.
  using Estimate = std::function<std::size_t(const protocol::BlobId&)>;
  static constexpr std::size_t mostRequests = 8; // unfinished; servers refuse more than 16

  // About this number of bytes is prefetched for each view; 0: none.
  explicit WishList(std::size_t prefetchBytes);

  // ---- what is wanted
  void Open(const std::string& model);
  // Cancels all requests for the model that was open.
  void CloseModel();
  // Replaces the list by these blobs, most urgent first. Blobs in flight are not requested again;
  // requests with no wanted blob are cancelled. If nothing is missing, prefetching continues.
  void Want(const std::vector<protocol::BlobId>& missing);
  // Requests nothing more until the next Want.
  void Clear() { this->Queue.clear(); }
  // The same; also cancels each request of which anything but pages and boxes is outstanding.
  void KeepTreeOnly();

  // ---- requests
  struct Manner
  {
    protocol::BlobId alone;     // is requested by itself
    bool treeOnly = false;      // stop before the first piece in the list
    bool originalApart = false; // no request mixes the original with anything else, because a
                                // request for the original may be refused as a whole
  };
  // Returns how many pages and boxes it has requested.
  std::size_t AskMore(const Estimate& bytesOf, const Manner& manner);
  // Whether more may be prefetched for the view that wants these pieces.
  bool MayPrefetch(const std::vector<PieceId>& view);
  // Requests as many of these as may be in flight, and as the prefetch limit of this view still
  // allows.
  void Prefetch(const std::vector<protocol::BlobId>& next, const Estimate& bytesOf);
  void SetPrefetch(std::size_t bytes);

  // ---- answers; false if nobody waits for them
  bool Opened(std::uint32_t request) { return this->Requests.SettleOpen(request); }
  // seconds: as in BandwidthMeter; ignored for a cached blob.
  bool Arrived(std::uint32_t request, const protocol::BlobId& blob, std::size_t bytes,
    double seconds, bool fromCache);
  bool Failed(std::uint32_t request, const protocol::BlobId& blob)
  {
    return this->Requests.Settle(request, blob);
  }
  // As RequestBook::TakeLate.
  bool TakeLate(std::uint32_t request, const protocol::BlobId& blob)
  {
    return this->Requests.TakeLate(request, blob);
  }
  // The request has failed. Returns what is still outstanding of it.
  std::vector<protocol::BlobId> Close(std::uint32_t request)
  {
    return this->Requests.Close(request);
  }
  bool IsPrefetched(const protocol::BlobId& blob) const { return this->Prefetched.count(blob) > 0; }
  // A blob has failed: returns whether it was prefetched. If so, nothing more is prefetched for
  // this view; when the blob is wanted, it is requested again.
  bool GiveUpPrefetch(const protocol::BlobId& blob);

  // ---- state. Whether nothing is wanted, and nothing is in flight.
  bool IsEmpty() const { return this->Queue.empty() && this->Requests.Empty(); }
  // The same without prefetches.
  bool IsIdle() const { return this->Queue.empty() && this->IsOnlyPrefetched(); }
  // Counts since the list was last idle.
  struct Progress
  {
    std::uint64_t blobsLoaded = 0, blobsWanted = 0, bytesLoaded = 0;
  };
  const Progress& GetProgress() const { return this->Counts; }
  const BandwidthMeter& Line() const { return this->Meter; }
  const RequestBook& Book() const { return this->Requests; }
  std::vector<SessionRequest> TakeOutgoing() { return this->Requests.TakeOutgoing(); }

private:
  std::uint32_t Ask(std::vector<protocol::BlobId> blobs);
  bool IsOnlyPrefetched() const;

  RequestBook Requests;
  BandwidthMeter Meter;
  std::deque<protocol::BlobId> Queue;    // blobs not requested yet
  std::set<protocol::BlobId> Prefetched; // requested though not wanted yet
  std::vector<PieceId> PrefetchedFor;    // wanted pieces of the view that this was for
  std::size_t PrefetchBytes,
    PrefetchLeft;                // bytes: for each view, and left for this view
  std::uint32_t LoneRequest = 0; // sent when nothing was outstanding, and nothing of it has arrived
  Progress Counts;
};

}
