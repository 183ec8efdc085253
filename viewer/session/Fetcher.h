// SPDX-License-Identifier: BSD-3-Clause
// Fetches what a session wants to show, and takes what arrives. Step "request" of the pipeline
// picture.
//   1. Updates the wish, at every input (LodSelection::Follow).
//   2. Chooses the shown cut, and lists what is missing, most urgent first; cancels requests that
//      are not wanted any more (LodSelection::Choose, WishList::Want).
//   3. Requests as much of the list as fills the connection (BandwidthMeter). More is requested as
//      blobs arrive.
//   4. When everything has arrived, prefetches what the view would want next.
// Step 2 visits every vertex of the wanted pieces, so it is done once a frame, and when nothing is
// in flight.
#pragma once

#include "viewer/session/SessionTypes.h"
#include "viewer/session/model/LodSelection.h"
#include "viewer/session/model/PickedRegion.h"
#include "viewer/session/model/ShownModel.h"
#include "viewer/session/requests/BlobHistory.h"
#include "viewer/session/requests/WishList.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace kdstream
{

class Fetcher
{
public:
  // prefetchBytes, clock, mostStatistics: as SessionOptions.
  Fetcher(ShownModel& model, LodSelection& lod, PickedRegion& region, std::size_t prefetchBytes,
    std::function<double()> clock, std::size_t mostStatistics);
  Fetcher(const Fetcher&) = delete;

  // Requests the description of a model. Nothing of the previous model is wanted any more.
  void Select(const std::string& model);

  // ---- requests, for the open model. Both return true if the preview has just appeared: then
  // everything must be updated again.
  bool Update(LodSelection::View view);
  // Call at each frame.
  bool FollowView(const LodSelection::View& view);
  // Makes way for a tap: cancels everything in flight except pages of the tree, because it would
  // arrive before what the tap needs.
  void GiveWayToTap();

  // ---- answers
  struct Answer
  {
    BlobArrival arrival = BlobArrival::Unwanted;
    const char* input = ""; // for traces: "blob"; "late": of a cancelled request; empty: ignored
    bool isNews = false;    // everything must be updated
  };
  // As ViewerSession::BlobArrived.
  Answer BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
    std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache);
  // False if nobody waits for this blob.
  bool BlobFailed(std::uint32_t request, const protocol::BlobId& blob, const std::string& message);
  bool RequestFailed(std::uint32_t request, const std::string& message);

  WishList& Wishes() { return this->Wanted; }
  const WishList& Wishes() const { return this->Wanted; }
  BlobHistory& History() { return this->Past; }
  const BlobHistory& History() const { return this->Past; }

private:
  bool Choose(const LodSelection::View& view);
  void AskMore(const LodSelection::View& view);
  Status Decode(
    const protocol::BlobId& blob, std::span<const std::uint8_t> bytes, BlobStatistics& entry);
  Answer TakeLate(
    std::uint32_t request, const protocol::BlobId& blob, std::span<const std::uint8_t> bytes);
  void Fail(const protocol::BlobId& blob, const std::string& message);

  ShownModel& Model;
  LodSelection& Lod;
  PickedRegion& Region;
  std::function<double()> Clock;
  WishList Wanted;
  BlobHistory Past;
};

}
