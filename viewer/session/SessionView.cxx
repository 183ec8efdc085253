// SPDX-License-Identifier: BSD-3-Clause
// What a session would like to see by the view, for its wish list (SessionWish.cxx): the pieces
// that the view needs (ViewRefinement), those that were tapped, textures, and what would be wanted
// next.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{
// A window as of 4 MB/s: what is on the way to a fine piece would be seen for some frames only.
constexpr std::size_t fastLine = std::size_t{ 1 } << 20;
constexpr double nearerNext = 1.5; // the view that is fetched ahead
}

using protocol::BlobId;

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
    const bool inSteps = this->Wanted.Line().Window() < fastLine;
    model.refinement.Follow(
      this->ViewOf(this->Eye, inSteps), this->TappedPieces(), this->FailedPieces);
    this->TellWhatIsMissed();
  }
  else
  {
    model.refinement.Reset();
  }
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

}
