// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see by the view, and how it gets it:
//   1. the pieces that the view needs (ViewRefinement), and those that were tapped: at every input,
//   2. the shown cut: all that is loaded of these and of what they need,
//   3. what is missing, in one order: most urgent first; what nobody wants any more is cancelled,
//   4. requests for as much of it as fills the line (LineMeter), and more as it comes.
//   5. when all of it is there, what would be wanted next.
// 2 and 3 look at every vertex of the wanted pieces, so they are done once a frame, and where
// nothing is under way that one could wait for.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{
// Unfinished requests at a time; servers refuse more than 16 messages.
constexpr std::size_t mostRequests = 8;
constexpr std::size_t bytesOfTreeBlob = 1500; // about
// A window as of 4 MB/s: what is on the way to a fine piece would be seen for some frames only.
constexpr std::size_t fastLine = std::size_t{ 1 } << 20;
constexpr double nearerNext = 1.5; // the view that is fetched ahead
}

using protocol::BlobId;

void ViewerSession::FollowView()
{
  if (this->Current && this->ChoiceIsDue)
  {
    this->ChooseByView();
  }
  this->FollowSection();
}

ViewRefinement::View ViewerSession::ViewOf(const Camera& camera, bool inSteps)
{
  const std::optional<SectionPlane>& section = this->Section.Plane();
  const bool isCloud = this->Current->description.triangles == 0; // whose points hide nothing
  return { camera, this->Current->tree, this->Pieces, isCloud ? nullptr : &this->Current->seen,
    inSteps, section ? &*section : nullptr };
}

void ViewerSession::RefineView()
{
  Model& model = *this->Current;
  if (this->IsPicking() && !this->PreviewsOnly)
  {
    this->FollowPick();
  }
  if (!this->Ends.empty())
  {
    this->FollowEnds();
  }
  this->MissingTree = model.tree.TakeMissing();
  std::erase_if(this->EarlierTaps,
    [&](std::uint32_t partition)
    {
      const Box* box = model.tree.Around(NodeOfPartition(partition, model.codec.depths));
      const bool isGone =
        box && this->Section.Plane() && this->Section.Plane()->CutsAwayAllOf(*box);
      return isGone || (box && !this->Eye.MaySee(*box));
    });
  if (this->Mode == ViewerMode::FullScreen && !this->Shown.IsEmpty() && !this->PreviewsOnly)
  {
    model.seen.LookThrough(this->Eye, model.isClosed);
    const bool inSteps = this->Meter.Window() < fastLine;
    model.refinement.Follow(
      this->ViewOf(this->Eye, inSteps), this->TappedPieces(), this->FailedPieces);
    this->TellWhatIsMissed();
  }
  else
  {
    model.refinement.Reset();
  }
  this->MissingTree.merge(model.tree.TakeMissing());
  this->FollowTiles();

  Situation now = this->GetSituation();
  if (this->LastSituation != now)
  {
    this->LastSituation = std::move(now);
    this->ChoiceIsDue = true;
  }
  const bool nothingIsComing = this->Queue.empty() && this->Book.Empty();
  if (this->ChoiceIsDue && (nothingIsComing || this->IsPicking() || this->Shown.IsEmpty()))
  {
    this->ChooseByView();
  }
  this->AskMore();
}

// What the view wants of textures, of the surface that is drawn.
void ViewerSession::FollowTiles()
{
  if (this->Tiles.AreThere() && !this->PreviewsOnly)
  {
    std::set<NodeId> tapped;
    for (const PieceId piece : this->TappedPieces())
    {
      tapped.insert(piece.node);
    }
    const bool all = this->Options.detail == DetailMode::Full;
    this->Tiles.Follow(*this->Shown.GetSurface(), this->Eye, tapped, all);
  }
}

// The region's partitions that the section does not cut away.
std::vector<std::uint32_t> ViewerSession::LeftOfRegion() const
{
  std::vector<std::uint32_t> left;
  const std::optional<SectionPlane>& section = this->Section.Plane();
  for (std::size_t i = 0; i < this->Region->partitions.size(); ++i)
  {
    if (!section || !section->CutsAwayAllOf(this->Region->boxes[i]))
    {
      left.push_back(this->Region->partitions[i]);
    }
  }
  return left;
}

// What is tapped and can be asked for, the newest first.
std::vector<PieceId> ViewerSession::TappedPieces() const
{
  std::vector<PieceId> pieces;
  const auto add = [&](std::uint32_t partition)
  {
    pieces.push_back(
      { Resolution::Original(), NodeOfPartition(partition, this->Current->codec.depths) });
  };
  for (const End& end : this->Ends)
  {
    std::for_each(end.partitions.begin(), end.partitions.end(), add);
  }
  if (this->Region)
  {
    const std::vector<std::uint32_t> region = this->LeftOfRegion();
    std::for_each(region.begin(), region.end(), add);
    std::for_each(this->EarlierTaps.begin(), this->EarlierTaps.end(), add);
  }
  return pieces;
}

// The region before the one that is tapped now stays, with those before it, as long as all of them
// are within half of the budget, and no more than one region may be.
void ViewerSession::AddToRegion(const PickedRegion& last)
{
  this->EarlierTaps.insert(
    this->EarlierTaps.begin(), last.partitions.begin(), last.partitions.end());
  const auto most = std::min<std::uint64_t>(
    this->MostOfRegion(), this->Options.refinement.triangles / 2 / this->TrianglesOfPartition());
  std::set<std::uint32_t> once;
  std::erase_if(this->EarlierTaps,
    [&](std::uint32_t partition) { return once.size() >= most || !once.insert(partition).second; });
}

void ViewerSession::ChooseByView()
{
  this->ChoiceIsDue = false;
  ++this->ChoicesMade;
  const bool wasEmpty = this->Shown.IsEmpty();
  ShownSurface::Needs needs = this->Shown.ShowLoaded(this->Wish(), this->Pieces);
  if (wasEmpty && !this->Shown.IsEmpty())
  {
    this->RefineView(); // the preview has just appeared
    return;
  }
  std::vector<BlobId> missing = this->InOrder(needs.missing);
  const std::vector<BlobId>& tiles = this->Tiles.Missing();
  missing.insert(missing.end(), tiles.begin(), tiles.end());
  std::set<BlobId> useful(missing.begin(), missing.end());
  if (missing.empty())
  {
    useful.merge(this->Ahead);
  }
  this->Ahead.clear();
  this->Book.CancelUseless(useful);
  for (const auto& [blob, request] : this->Book.AllOwed())
  {
    if (missing.empty() && useful.count(blob) > 0)
    {
      this->Ahead.insert(blob);
    }
  }
  this->Queue.clear();
  std::copy_if(missing.begin(), missing.end(), std::back_inserter(this->Queue),
    [this](const BlobId& blob) { return !this->Book.IsOwed(blob); });
  needs.all.insert(this->Shown.Pieces().begin(), this->Shown.Pieces().end());
  this->Pieces.Pin(std::move(needs.all));
  this->AskMore();
}

// All that is missing and can be had, in the order in which it is wanted: the tree, without which
// nothing can be judged; the way to each tapped partition and the partition; then the most urgent.
std::vector<BlobId> ViewerSession::InOrder(const std::vector<PieceId>& missing)
{
  Model& model = *this->Current;
  const TreeDepths& depths = model.codec.depths;
  std::vector<BlobId> order;
  std::copy_if(this->MissingTree.begin(), this->MissingTree.end(), std::back_inserter(order),
    [this](const BlobId& blob) { return this->FailedTree.count(blob) == 0; });

  std::map<NodeId, std::size_t> tapped; // place of a partition's node
  for (const PieceId piece : this->TappedPieces())
  {
    tapped.emplace(piece.node, tapped.size());
  }
  // The first of the taps below a piece; those that lie below it are one interval of nodes.
  const auto firstTapBelow = [&](PieceId piece)
  {
    const unsigned below = depths.partition - DepthOfNode(piece.node);
    std::size_t first = std::numeric_limits<std::size_t>::max();
    for (auto tap = tapped.lower_bound(piece.node << below);
         tap != tapped.end() && tap->first >> below == piece.node; ++tap)
    {
      first = std::min(first, tap->second);
    }
    return first;
  };
  struct Entry
  {
    std::size_t tap;
    double urgency;
    PieceId piece;
  };
  std::vector<Entry> entries;
  for (const PieceId piece : missing)
  {
    if (this->FailedPieces.count(piece) == 0)
    {
      const std::size_t tap = firstTapBelow(piece);
      const bool isTapped = tap != std::numeric_limits<std::size_t>::max();
      entries.push_back(
        { tap, isTapped ? 0 : model.refinement.UrgencyOf(piece, this->Eye, model.tree), piece });
    }
  }
  std::sort(entries.begin(), entries.end(),
    [](const Entry& a, const Entry& b)
    {
      if (a.tap != b.tap)
      {
        return a.tap < b.tap;
      }
      return a.urgency != b.urgency ? a.urgency > b.urgency : a.piece < b.piece;
    });
  for (const Entry& entry : entries)
  {
    order.push_back(BlobOfPiece(entry.piece, depths));
  }
  return order;
}

// About, of a blob that has not come.
std::size_t ViewerSession::BytesOf(const BlobId& blob)
{
  if (blob.kind == protocol::BlobKind::Texture)
  {
    return this->Tiles.ExpectedBytes();
  }
  return IsOfPiece(blob) ? this->Current->refinement.BlobBytes(
                             PieceOfBlob(blob, this->Current->codec.depths), this->Current->tree)
                         : bytesOfTreeBlob;
}

// In requests of a quarter of what may be under way, so that calling one back costs little. While a
// tap waits for the tree nothing else is asked for.
void ViewerSession::AskMore()
{
  const std::size_t window = this->Meter.Window();
  std::size_t underWay = 0;
  for (const auto& [blob, request] : this->Book.AllOwed())
  {
    underWay += this->BytesOf(blob);
  }
  const bool tapWaits = this->IsPicking() &&
                        std::any_of(this->MissingTree.begin(), this->MissingTree.end(),
                          [this](const BlobId& blob) { return this->FailedTree.count(blob) == 0; });
  const auto mayAsk = [&]
  { return !this->Queue.empty() && !(tapWaits && !IsOfTree(this->Queue.front())); };
  const BlobId preview = BlobOfPiece(
    { Resolution::Level(this->Current->policy.PreviewLevel()), 1 }, this->Current->codec.depths);
  while (mayAsk() && underWay < window && this->Book.RequestCount() < mostRequests)
  {
    SessionRequest request;
    request.kind =
      this->Queue.front() == preview ? SessionRequest::Kind::Preview : SessionRequest::Kind::Blobs;
    std::size_t bytes = 0;
    do
    {
      const BlobId blob = this->Queue.front();
      this->AskedForPick += this->IsPicking() && IsOfTree(blob) ? 1 : 0;
      bytes += this->BytesOf(blob);
      request.blobs.push_back(blob);
      this->Queue.pop_front();
    } while (mayAsk() && request.kind == SessionRequest::Kind::Blobs && bytes < window / 4);
    underWay += bytes;
    const bool alone = this->Book.Empty();
    const std::uint32_t id = this->Book.Send(std::move(request));
    this->LoneRequest = alone ? id : this->LoneRequest;
  }
  if (this->AskedForPick > this->Options.mostBlobsOfPick)
  {
    this->LastError = "What is around the tap cannot be told: too much of the tree is there.";
    this->DropPick();
  }
  this->AskAhead();
  this->CountProgress();
}

// Asks for what would be wanted next, while nothing is wanted. As far as it goes at a time: more
// when that has come.
void ViewerSession::AskAhead()
{
  const bool mayAsk = this->ByView() && this->Mode == ViewerMode::FullScreen &&
                      !this->IsPicking() && this->Queue.empty() && this->Book.Empty() &&
                      !this->ChoiceIsDue && !this->PreviewsOnly;
  if (this->Options.aheadBytes == 0 || !mayAsk)
  {
    return;
  }
  if (this->AheadOf != this->Current->refinement.Pieces())
  {
    this->AheadOf = this->Current->refinement.Pieces();
    this->AheadSpent = 0;
  }
  if (this->AheadSpent >= this->Options.aheadBytes)
  {
    return;
  }
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  std::size_t bytes = 0;
  for (const BlobId& blob : this->WantedNext())
  {
    bytes += this->BytesOf(blob);
    if (bytes > this->Meter.Window() || this->AheadSpent + bytes > this->Options.aheadBytes)
    {
      break;
    }
    request.blobs.push_back(blob);
  }
  this->AheadSpent = request.blobs.empty() ? this->Options.aheadBytes : this->AheadSpent + bytes;
  this->Ahead = { request.blobs.begin(), request.blobs.end() };
  if (!request.blobs.empty())
  {
    this->Book.Send(std::move(request));
  }
}

// What is missing for a view that is nearer, the tree first, then the most urgent.
std::vector<BlobId> ViewerSession::WantedNext()
{
  Model& model = *this->Current;
  Camera nearer = this->Eye;
  const Viewport& screen = nearer.GetViewport();
  nearer.Zoom(nearerNext, 0.5 * screen.width, 0.5 * screen.height);
  model.next.Follow(this->ViewOf(nearer, false), this->TappedPieces(), this->FailedPieces);
  std::vector<BlobId> order;
  for (const BlobId& blob : model.tree.TakeMissing())
  {
    if (this->FailedTree.count(blob) == 0)
    {
      order.push_back(blob);
    }
  }
  std::vector<std::pair<double, PieceId>> pieces;
  const Closure closure = MakeClosure(model.codec.depths, this->Wish().base, model.next.Pieces(),
    [this](PieceId id) { return this->Pieces.Peek(id); });
  for (const PieceId piece : closure.missing)
  {
    if (this->FailedPieces.count(piece) == 0)
    {
      pieces.emplace_back(-model.next.UrgencyOf(piece, nearer, model.tree), piece);
    }
  }
  std::sort(pieces.begin(), pieces.end());
  for (const auto& [urgency, piece] : pieces)
  {
    order.push_back(BlobOfPiece(piece, model.codec.depths));
  }
  return order;
}

bool ViewerSession::IsOnlyAhead() const
{
  const auto& owed = this->Book.AllOwed();
  return this->Book.Empty() || (!owed.empty() && std::all_of(owed.begin(), owed.end(),
                                                   [this](const auto& each)
                                                   { return this->Ahead.count(each.first) > 0; }));
}

void ViewerSession::CountProgress()
{
  if (this->Queue.empty() && this->IsOnlyAhead())
  {
    this->BlobsLoaded = this->BlobsWanted = this->BytesLoaded = 0;
    return;
  }
  this->BlobsWanted = this->BlobsLoaded + this->Book.AllOwed().size() + this->Queue.size();
}

}
