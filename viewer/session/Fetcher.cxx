// SPDX-License-Identifier: BSD-3-Clause
// Fetches what a session wants to show: see Fetcher.h.
#include "viewer/session/Fetcher.h"

#include <utility>

namespace kdstream
{
namespace
{

using protocol::BlobId;
using protocol::BlobKind;

// The window of a connection of 4 MB/s. On a faster one, intermediate pieces would be visible only
// briefly.
constexpr std::size_t fastLine = std::size_t{ 1 } << 20;

// The name of a blob's kind in statistics.
const char* NameOf(const BlobId& blob, bool isPreview)
{
  return isPreview                          ? "preview"
         : blob.kind == BlobKind::Partition ? "partition"
         : IsOfTexture(blob)                ? "texture"
                                            : "level";
}

}

Fetcher::Fetcher(ShownModel& model, LodSelection& lod, PickedRegion& region,
  std::size_t prefetchBytes, std::function<double()> clock, std::size_t mostStatistics)
  : Model(model)
  , Lod(lod)
  , Region(region)
  , Clock(std::move(clock))
  , Wanted(prefetchBytes)
  , Past(mostStatistics)
{
}

void Fetcher::Select(const std::string& model)
{
  this->Wanted.CloseModel();
  this->Past.CloseModel();
  this->Wanted.Open(model);
}

// ---- requests

bool Fetcher::Update(LodSelection::View view)
{
  view.inSteps = this->Wanted.Line().Window() < fastLine;
  this->Lod.Follow(view);
  const bool waitsForNothing =
    this->Wanted.IsEmpty() || this->Region.IsPicking() || this->Model.surface.IsEmpty();
  if (this->Lod.IsDue() && waitsForNothing && this->Choose(view))
  {
    return true;
  }
  this->AskMore(view);
  return false;
}

bool Fetcher::FollowView(const LodSelection::View& view)
{
  return this->Lod.IsDue() && this->Choose(view);
}

bool Fetcher::Choose(const LodSelection::View& view)
{
  const auto missing = this->Lod.Choose(view);
  if (missing)
  {
    this->Wanted.Want(*missing);
    this->AskMore(view);
  }
  return !missing;
}

void Fetcher::GiveWayToTap()
{
  this->Wanted.KeepTreeOnly();
  this->Lod.SetDue();
}

// Requests more of the list. While a tap waits for the tree, nothing else is requested; the preview
// is requested by itself. If nothing is wanted, prefetches as much as may be in flight, and more
// when that has arrived.
void Fetcher::AskMore(const LodSelection::View& view)
{
  const auto bytesOf = [this](const BlobId& blob) { return this->Lod.BytesOf(blob); };
  const bool byView = this->Lod.ByView();
  const bool previewFirst = !byView && this->Model.surface.IsEmpty();
  const bool tapWaits = this->Region.IsPicking() && !previewFirst && this->Lod.WaitsForTree();
  this->Region.NoteAsked(
    this->Wanted.AskMore(bytesOf, { this->Model.PreviewBlob(), tapWaits, !byView }));
  const bool mayPrefetch = byView && view.isFullScreen && !this->Region.IsPicking() &&
                           !this->Lod.IsDue() && !view.previewsOnly;
  if (mayPrefetch && this->Wanted.MayPrefetch(this->Lod.WantedByView()))
  {
    this->Wanted.Prefetch(this->Lod.WantedNext(view), bytesOf);
  }
}

// ---- answers

Fetcher::Answer Fetcher::BlobArrived(std::uint32_t request, const BlobId& blob,
  std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache)
{
  const bool isWanted = this->Model.open && this->Wanted.Arrived(request, blob, bytes.size(),
                                              transmissionSeconds, fromCache);
  this->Past.Count(bytes.size(), !isWanted);
  if (!isWanted)
  {
    return this->TakeLate(request, blob, bytes);
  }
  if (!fromCache)
  {
    for (const BlobId& lost : this->Model.failed.TakeLost(blob, this->Model.Depths()))
    {
      this->Model.tiles.Retry(lost);
    }
  }
  BlobStatistics entry;
  entry.what = NameOf(blob, blob == this->Model.PreviewBlob());
  entry.id = protocol::BlobName(blob);
  entry.bytes = bytes.size();
  entry.transmissionSeconds = transmissionSeconds;
  entry.fromCache = fromCache;
  const Status decoded = this->Decode(blob, bytes, entry);
  if (!decoded)
  {
    this->Fail(blob, decoded.GetError().message);
  }
  else if (IsOfPiece(blob))
  {
    this->Past.Add(PieceOfBlob(blob, this->Model.Depths()), std::move(entry));
  }
  return { decoded ? BlobArrival::Taken : BlobArrival::Damaged, "blob", true };
}

// Takes a blob that was in flight when it was cancelled: it is kept for later views, if the cache
// has room.
Fetcher::Answer Fetcher::TakeLate(
  std::uint32_t request, const BlobId& blob, std::span<const std::uint8_t> bytes)
{
  if (!this->Model.open || !this->Wanted.TakeLate(request, blob))
  {
    return {};
  }
  if (!IsOfPiece(blob))
  {
    return { BlobArrival::Taken };
  }
  const PieceId piece = PieceOfBlob(blob, this->Model.Depths());
  if (this->Model.pieces.Peek(piece))
  {
    return { BlobArrival::Taken, "late" };
  }
  BlobStatistics unused;
  if (!this->Decode(blob, bytes, unused))
  {
    return { BlobArrival::Damaged, "late" };
  }
  this->Past.AddLate(piece, bytes.size());
  return { BlobArrival::Taken, "late", true };
}

Status Fetcher::Decode(
  const BlobId& blob, std::span<const std::uint8_t> bytes, BlobStatistics& entry)
{
  if (IsOfTree(blob))
  {
    return this->Model.open->tree.Add(blob, bytes);
  }
  const PieceId id = PieceOfBlob(blob, this->Model.Depths());
  if (IsOfTexture(blob))
  {
    return this->Model.tiles.Add(blob, bytes, this->Model.pieces.Peek(id));
  }
  const double begin = this->Clock ? this->Clock() : 0;
  auto piece = DecodePiece(bytes, id, this->Model.open->codec);
  entry.parsingSeconds = this->Clock ? this->Clock() - begin : 0;
  KDSTREAM_TRY(piece);
  entry.vertices = piece->ownVertices;
  entry.triangles = piece->triangles.size();
  this->Lod.Add(*piece);
  this->Model.Add(std::move(*piece));
  return {};
}

void Fetcher::Fail(const BlobId& blob, const std::string& message)
{
  if (this->Wanted.GiveUpPrefetch(blob))
  {
    return; // nobody waits for this blob
  }
  std::optional<PieceId> piece;
  if (IsOfPiece(blob))
  {
    piece = PieceOfBlob(blob, this->Model.Depths());
  }
  else if (IsOfTree(blob))
  {
    this->Region.DropPick();
  }
  else
  {
    this->Model.tiles.Fail(blob);
  }
  this->Model.failed.Add(blob, piece, message, piece && this->Lod.MayDoWithout(*piece));
}

bool Fetcher::BlobFailed(std::uint32_t request, const BlobId& blob, const std::string& message)
{
  const bool isWanted = this->Model.open && this->Wanted.Failed(request, blob);
  if (isWanted)
  {
    this->Model.failed.Settle(blob);
    this->Fail(blob, message);
  }
  return isWanted;
}

bool Fetcher::RequestFailed(std::uint32_t request, const std::string& message)
{
  const SessionRequest* asked = this->Wanted.Book().Find(request);
  if (!asked)
  {
    return false;
  }
  const bool opens = asked->kind == SessionRequest::Kind::Open;
  for (const BlobId& blob : this->Wanted.Close(request))
  {
    if (!this->Wanted.IsPrefetched(blob))
    {
      this->Model.failed.AddLost(blob, message);
    }
    this->Fail(blob, message);
  }
  if (opens)
  {
    this->Model.failed.Report(this->Model.id + " cannot be opened: " + message);
  }
  return true;
}

}
