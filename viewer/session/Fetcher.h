// SPDX-License-Identifier: BSD-3-Clause
// How a session gets what it would like to see, and takes what comes. Step "request" of the
// pipeline picture.
//   1. the wish, at every input (LodSelection::Follow),
//   2. the shown cut, and what is missing, in one list, most urgent first; what nobody wants any
//      more is cancelled (LodSelection::Choose, WishList::Want),
//   3. requests for as much of it as fills the connection (LineMeter), and more as it comes,
//   4. when all of it is there, what the view would want next.
// 2 looks at every vertex of the wanted pieces, so it is done once a frame, and where nothing is in
// flight that one could wait for.
#pragma once

#include "viewer/session/SessionTypes.h"
#include "viewer/session/line/BlobHistory.h"
#include "viewer/session/line/WishList.h"
#include "viewer/session/model/LodSelection.h"
#include "viewer/session/model/PickedRegion.h"
#include "viewer/session/model/ShownModel.h"

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

  // Asks for the description of a model; of the last one nothing is wanted any more.
  void Select(const std::string& model);

  // ---- asking, of the model that is open; true where the preview has just appeared: all is to be
  // updated anew
  bool Update(LodSelection::View view);
  // At a frame.
  bool FollowView(const LodSelection::View& view);
  // Much may be in flight, and it would come before what a tap needs: it is cancelled, but for the
  // tree.
  void GiveWayToTap();

  // ---- what comes
  struct Answer
  {
    BlobArrival arrival = BlobArrival::Unwanted;
    const char* input =
      "";                // "blob", or "late" where its request had been cancelled; empty: ignored
    bool isNews = false; // all is to be updated
  };
  // As ViewerSession::BlobArrived.
  Answer BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
    std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache);
  // False where nobody has waited for it.
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
