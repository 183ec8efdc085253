// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see, and how it gets it. Step "request" of the README's picture.
//   1. the wish: what the view needs (SessionView.cxx), one level for all of the model, or all of
//   it as the original; and what was tapped: at every input,
//   2. the shown cut: of a view all that is loaded of the wish and of what it needs; a level once
//   it is whole,
//   3. what is missing, in one list: most urgent first; what nobody wants any more is cancelled,
//   4. requests for as much of it as fills the line (LineMeter), and more as it comes.
//   5. when all of it is there, what the view would want next.
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
}

using protocol::BlobId;

// The level that the zoom asks for, or the next coarser one of which no piece has failed.
unsigned ViewerSession::EffectiveLevel() const
{
  unsigned level = this->Target;
  const auto failed = [this](unsigned d)
  {
    const auto first = this->FailedPieces.lower_bound({ Resolution::Level(d), 0 });
    return first != this->FailedPieces.end() && first->resolution == Resolution::Level(d);
  };
  while (level > this->Current->policy.PreviewLevel() && failed(level))
  {
    --level;
  }
  return level;
}

SurfaceWish ViewerSession::Wish() const
{
  const auto preview = Resolution::Level(this->Current->policy.PreviewLevel());
  if (this->Shown.IsEmpty()) // it comes first, alone
  {
    return { preview, {} };
  }
  switch (this->Options.detail)
  {
    case DetailMode::View:
    {
      SurfaceWish wish{ preview, this->Current->refinement.Pieces() };
      const std::vector<PieceId> tapped = this->TappedPieces();
      wish.pieces.insert(wish.pieces.end(), tapped.begin(), tapped.end());
      return wish;
    }
    case DetailMode::Level:
      return { Resolution::Level(this->EffectiveLevel()), this->TappedPieces() };
    case DetailMode::Full:
      break;
  }
  const bool full = this->Mode == ViewerMode::FullScreen;
  return { full ? Resolution::Original() : preview, {} };
}

BlobId ViewerSession::PreviewBlob() const
{
  return BlobOfPiece(
    { Resolution::Level(this->Current->policy.PreviewLevel()), 1 }, this->Current->codec.depths);
}

ViewerSession::Situation ViewerSession::GetSituation() const
{
  Situation now;
  now.wish = this->Wish();
  if (this->Region)
  {
    now.cell = this->Region->cell;
    now.rings = this->Region->rings;
  }
  now.tree = this->MissingTree;
  now.tiles = this->Tiles.Missing();
  now.failedPieces = this->FailedPieces;
  now.failedTree = this->FailedTree;
  now.pieces = this->Pieces.Version();
  return now;
}

// Most inputs only move the camera. To find that nothing is to be done then would mean to look at
// every vertex of the pieces above a region, at each move of a finger.
void ViewerSession::Update()
{
  if (!this->Current)
  {
    return;
  }
  KnownTree& tree = this->Current->tree;
  if (this->IsPicking() && !this->PreviewsOnly)
  {
    this->FollowPick();
  }
  if (!this->Ends.empty())
  {
    this->FollowEnds();
  }
  this->MissingTree = tree.TakeMissing();
  if (this->ByView())
  {
    this->RefineView();
  }
  else if (this->Options.detail == DetailMode::Level && this->Mode == ViewerMode::FullScreen)
  {
    this->FollowLevel();
  }
  this->MissingTree.merge(tree.TakeMissing());
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
    this->Choose();
  }
  this->AskMore();
}

void ViewerSession::FollowView()
{
  if (this->Current && this->ChoiceIsDue)
  {
    this->Choose();
  }
  this->FollowSection();
}

// For a tap to come, where one looks closely: the pages that tell of pieces in view no finer than
// the level that the zoom asks for.
void ViewerSession::FollowLevel()
{
  if (this->Current->description.detail != ModelDetail::Preview)
  {
    const unsigned onePiece = this->Current->codec.depths.onePiece;
    this->Current->tree.Walk(
      [this, onePiece](NodeId page, const Box& box) {
        return page == 1 || (onePiece + DepthOfNode(page) < this->Target && this->Eye.MaySee(box));
      });
  }
}

void ViewerSession::Choose()
{
  this->ChoiceIsDue = false;
  ++this->ChoicesMade;
  const bool wasEmpty = this->Shown.IsEmpty();
  ShownSurface::Needs needs =
    this->ByView() ? this->Shown.ShowLoaded(this->Wish(), this->Pieces)
                   : this->Shown.ShowWhole(this->Wish(), this->Pieces, this->FailedPieces);
  if (wasEmpty && !this->Shown.IsEmpty())
  {
    this->Update(); // the preview has just appeared
    return;
  }
  const std::vector<BlobId> missing = this->InOrder(needs.missing);
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
// nothing can be judged; the way to each tapped partition and the partition; then the most urgent;
// by one level for all, coarse before fine. Last textures, which are drawn on what is there.
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
      const bool isUrgent = this->ByView() && tap == std::numeric_limits<std::size_t>::max();
      entries.push_back(
        { tap, isUrgent ? model.refinement.UrgencyOf(piece, this->Eye, model.tree) : 0, piece });
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
  const std::vector<BlobId>& tiles = this->Tiles.Missing();
  order.insert(order.end(), tiles.begin(), tiles.end());
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

// In requests of a quarter of what may be under way, so that calling one back costs little; the
// preview by itself. While a tap waits for the tree nothing else is asked for.
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
  while (mayAsk() && underWay < window && this->Book.RequestCount() < mostRequests)
  {
    SessionRequest request;
    request.kind = SessionRequest::Kind::Blobs;
    const bool isPreview = this->Queue.front() == this->PreviewBlob();
    std::size_t bytes = 0;
    do
    {
      const BlobId blob = this->Queue.front();
      this->AskedForPick += this->IsPicking() && IsOfTree(blob) ? 1 : 0;
      bytes += this->BytesOf(blob);
      request.blobs.push_back(blob);
      this->Queue.pop_front();
    } while (mayAsk() && !isPreview && bytes < window / 4);
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
