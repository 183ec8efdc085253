// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see, and how it gets it:
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
  SurfaceWish wish;
  // The preview comes first, alone.
  wish.level =
    this->Shown.IsEmpty() ? this->Current->policy.PreviewLevel() : this->EffectiveLevel();
  if (this->Region && !this->Shown.IsEmpty())
  {
    wish.region = this->Region->partitions;
  }
  return wish;
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
  now.missingPages = this->Current->missingPages.size(); // of one model they only become fewer
  now.failedPieces = this->FailedPieces;
  now.failedPages = this->FailedPages;
  now.pieces = this->Pieces.Version();
  now.cut = this->Shown.CutVersion();
  now.requests = this->Book.Version();
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
  Situation now = this->GetSituation();
  if (this->LastSituation != now)
  {
    this->LastSituation = std::move(now);
    ++this->ChoicesMade;
    this->ChooseAndAsk();
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
  for (const NodeId page : this->Current->missingPages)
  {
    wanted.insert(BlobId::TreePage(page));
  }
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
  SessionRequest tree;
  tree.kind = SessionRequest::Kind::Tree;
  for (const NodeId page : this->Current->missingPages)
  {
    const BlobId blob = BlobId::TreePage(page);
    if (!this->Book.IsOwed(blob) && this->FailedPages.count(page) == 0)
    {
      tree.blobs.push_back(blob);
    }
  }
  if (!tree.blobs.empty())
  {
    this->BlobsWanted += tree.blobs.size();
    this->Book.Send(std::move(tree));
  }
  this->RequestRegion(fresh);
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

// What is missing of the region's partitions, nearest first.
void ViewerSession::RequestRegion(const std::vector<PieceId>& missing)
{
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

}
