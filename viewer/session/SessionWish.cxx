// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see, and how it gets it. Step "request" of the pipeline picture.
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
  if (this->ChoiceIsDue && (this->Wanted.IsEmpty() || this->IsPicking() || this->Shown.IsEmpty()))
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
  this->Wanted.Want(this->InOrder(needs.missing));
  needs.all.insert(this->Shown.Pieces().begin(), this->Shown.Pieces().end());
  this->Pieces.Pin(std::move(needs.all));
  this->AskMore();
}

// All that is missing and can be had, in the order in which it is wanted: the tree, without which
// nothing can be judged; the way to each tapped partition and the partition; then the most urgent;
// by one level for all, coarse before fine, the preview before all else while nothing is shown.
// Last textures, which are drawn on what is there.
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
  if (!this->ByView() && this->Shown.IsEmpty())
  {
    const auto preview = std::find(order.begin(), order.end(), this->PreviewBlob());
    if (preview != order.end())
    {
      order.erase(preview);
      order.insert(order.begin(), this->PreviewBlob());
    }
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

// While a tap waits for the tree nothing else is asked for; the preview by itself. What would be
// wanted next is, while nothing is wanted: as far as it goes at a time, more when that has come.
void ViewerSession::AskMore()
{
  const auto bytesOf = [this](const BlobId& blob) { return this->BytesOf(blob); };
  const bool previewFirst = !this->ByView() && this->Shown.IsEmpty();
  const bool tapWaits = this->IsPicking() && !previewFirst &&
                        std::any_of(this->MissingTree.begin(), this->MissingTree.end(),
                          [this](const BlobId& blob) { return this->FailedTree.count(blob) == 0; });
  const std::size_t ofTree =
    this->Wanted.AskMore(bytesOf, { this->PreviewBlob(), tapWaits, !this->ByView() });
  this->AskedForPick += this->IsPicking() ? ofTree : 0;
  if (this->AskedForPick > this->Options.mostBlobsOfPick)
  {
    this->LastError = "What is around the tap cannot be told: too much of the tree is there.";
    this->DropPick();
  }
  const bool mayAskAhead = this->ByView() && this->Mode == ViewerMode::FullScreen &&
                           !this->IsPicking() && !this->ChoiceIsDue && !this->PreviewsOnly;
  if (mayAskAhead && this->Wanted.MayAskAhead(this->Current->refinement.Pieces()))
  {
    this->Wanted.AskAhead(this->WantedNext(), bytesOf);
  }
}

}
