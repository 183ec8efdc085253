// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see, and how it gets it, where one level is shown for all of the
// model (by the view: SessionView.cxx):
//   1. the wish: the level that the zoom asks for (or a coarser one, where it failed) and the
//   picked region,
//   2. the shown cut: the best that the loaded pieces allow,
//   3. cancel what nobody wants any more, and ask for what is missing.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

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
  if (!this->ByView())
  {
    now.cut = this->Shown.CutVersion();
    now.requests = this->Book.Version();
  }
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
  if (this->ByView())
  {
    this->RefineView();
    return;
  }
  this->FollowTree();
  this->FollowTiles();
  Situation now = this->GetSituation();
  if (this->LastSituation != now)
  {
    this->LastSituation = std::move(now);
    ++this->ChoicesMade;
    this->ChooseAndAsk();
  }
}

// What is needed of the tree: for a tap that waits, and, where one looks closely, the pages that
// tell of pieces in view no finer than the level that the zoom asks for.
void ViewerSession::FollowTree()
{
  KnownTree& tree = this->Current->tree;
  this->FollowPick();
  this->FollowEnds();
  this->MissingTree = tree.TakeMissing();
  const bool hasTree = this->Current->description.detail != ModelDetail::Preview;
  if (hasTree && this->Mode == ViewerMode::FullScreen && this->Options.detail == DetailMode::Level)
  {
    const unsigned onePiece = this->Current->codec.depths.onePiece;
    tree.Walk(
      [this, onePiece](NodeId page, const Box& box) {
        return page == 1 || (onePiece + DepthOfNode(page) < this->Target && this->Eye.MaySee(box));
      });
    this->MissingTree.merge(tree.TakeMissing());
  }
}

void ViewerSession::ChooseAndAsk()
{
  this->Shown.Choose(this->Wish(), this->Pieces, this->FailedPieces);
  // The preview may just have appeared: wish again.
  ShownSurface::Needs needs = this->Shown.NeedsOf(this->Wish(), this->Pieces);

  const TreeDepths& depths = this->Current->codec.depths;
  std::set<BlobId> wanted;
  std::vector<PieceId> missing;
  for (const PieceId piece : needs.missing)
  {
    wanted.insert(BlobOfPiece(piece, depths));
    if (this->FailedPieces.count(piece) == 0)
    {
      missing.push_back(piece);
    }
  }
  wanted.insert(this->MissingTree.begin(), this->MissingTree.end());
  wanted.insert(this->Tiles.Missing().begin(), this->Tiles.Missing().end());
  this->Book.CancelUnwanted(wanted);
  if (this->Book.Empty())
  {
    this->BlobsLoaded = this->BlobsWanted = this->BytesLoaded = 0;
  }
  this->RequestMissing(missing);

  needs.all.insert(this->Shown.Pieces().begin(), this->Shown.Pieces().end());
  this->Pieces.Pin(std::move(needs.all));
}

void ViewerSession::RequestMissing(const std::vector<PieceId>& missing)
{
  std::vector<PieceId> fresh;
  const TreeDepths& depths = this->Current->codec.depths;
  for (const PieceId piece : missing)
  {
    if (!this->Book.IsOwed(BlobOfPiece(piece, depths)))
    {
      fresh.push_back(piece);
    }
  }
  this->RequestLevels(fresh);
  this->RequestTree();
  this->RequestRegion(fresh);
  this->RequestTiles();
}

void ViewerSession::RequestTiles()
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  std::copy_if(this->Tiles.Missing().begin(), this->Tiles.Missing().end(),
    std::back_inserter(request.blobs),
    [this](const BlobId& blob) { return !this->Book.IsOwed(blob); });
  if (!request.blobs.empty())
  {
    this->BlobsWanted += request.blobs.size();
    this->Book.Send(std::move(request));
  }
}

// Pages, then boxes. A tap that would need too many is dropped.
void ViewerSession::RequestTree()
{
  for (const auto kind : { SessionRequest::Kind::Tree, SessionRequest::Kind::Boxes })
  {
    SessionRequest request;
    request.kind = kind;
    for (const BlobId& blob : this->MissingTree)
    {
      const bool page = blob.kind == protocol::BlobKind::Tree;
      if (page == (kind == SessionRequest::Kind::Tree) && !this->Book.IsOwed(blob) &&
          this->FailedTree.count(blob) == 0)
      {
        request.blobs.push_back(blob);
      }
    }
    if (request.blobs.empty())
    {
      continue;
    }
    this->AskedForPick += this->IsPicking() ? request.blobs.size() : 0;
    if (this->AskedForPick > this->Options.mostBlobsOfPick)
    {
      this->LastError = "What is around the tap cannot be told: too much of the tree is there.";
      this->DropPick();
      return;
    }
    this->BlobsWanted += request.blobs.size();
    this->Book.Send(std::move(request));
  }
}

// One request a level; `missing` is ascending, so coarse before fine.
void ViewerSession::RequestLevels(const std::vector<PieceId>& missing)
{
  const unsigned preview = this->Current->policy.PreviewLevel();
  for (auto piece = missing.begin(); piece != missing.end() && !piece->resolution.IsOriginal();)
  {
    const Resolution resolution = piece->resolution;
    SessionRequest request;
    request.kind = resolution == Resolution::Level(preview) ? SessionRequest::Kind::Preview
                                                            : SessionRequest::Kind::Level;
    request.level = static_cast<std::uint8_t>(resolution.Depth());
    for (; piece != missing.end() && piece->resolution == resolution; ++piece)
    {
      request.blobs.push_back(BlobOfPiece(*piece, this->Current->codec.depths));
    }
    this->BlobsWanted += request.blobs.size();
    this->Book.Send(std::move(request));
  }
}

// What is missing of the region's partitions, nearest first; of all the model's, in their order.
void ViewerSession::RequestRegion(const std::vector<PieceId>& missing)
{
  if (this->Options.detail == DetailMode::Full)
  {
    this->RequestAllPartitions(missing);
    return;
  }
  this->RequestAllPartitions(this->BesideRegion(missing));
  if (!this->Region)
  {
    return;
  }
  SessionRequest request;
  request.kind =
    this->Region->whole ? SessionRequest::Kind::Region : SessionRequest::Kind::Partitions;
  request.cell = this->Region->cell;
  request.rings = static_cast<std::uint8_t>(this->Region->rings);
  for (const std::uint32_t partition : this->Region->partitions)
  {
    const PieceId piece{ Resolution::Original(),
      NodeOfPartition(partition, this->Current->codec.depths) };
    if (std::binary_search(missing.begin(), missing.end(), piece))
    {
      request.blobs.push_back(BlobId::Partition(partition));
    }
    else if (this->Region->whole)
    {
      request.except.push_back(partition);
    }
  }
  if (!request.blobs.empty())
  {
    this->BlobsWanted += request.blobs.size();
    this->Book.Send(std::move(request));
  }
}

// What measurements need.
std::vector<PieceId> ViewerSession::BesideRegion(std::vector<PieceId> missing) const
{
  std::erase_if(missing,
    [this](PieceId piece)
    {
      const auto isIt = [&](std::uint32_t partition)
      { return NodeOfPartition(partition, this->Current->codec.depths) == piece.node; };
      return !piece.resolution.IsOriginal() ||
             (this->Region &&
               std::any_of(this->Region->partitions.begin(), this->Region->partitions.end(), isIt));
    });
  return missing;
}

void ViewerSession::RequestAllPartitions(const std::vector<PieceId>& missing)
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Partitions;
  for (const PieceId piece : missing)
  {
    if (piece.resolution.IsOriginal())
    {
      request.blobs.push_back(BlobOfPiece(piece, this->Current->codec.depths));
    }
  }
  if (!request.blobs.empty())
  {
    this->BlobsWanted += request.blobs.size();
    this->Book.Send(std::move(request));
  }
}

}
