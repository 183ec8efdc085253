// SPDX-License-Identifier: BSD-3-Clause
// LOD selection: see LodSelection.h.
#include "viewer/session/model/LodSelection.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>

namespace kdstream
{
namespace
{

constexpr std::size_t bytesOfTreeBlob = 1500; // approximate
constexpr double nearerNext = 1.5; // pieces are prefetched for a view nearer by this factor
constexpr auto notTapped = std::numeric_limits<std::size_t>::max();

// Finds which tapped partitions are below a piece: their nodes are one interval.
class Taps
{
public:
  Taps(const std::vector<PieceId>& tapped, const TreeDepths& depths)
    : Depth(depths.partition)
  {
    for (const PieceId piece : tapped)
    {
      this->Places.emplace(piece.node, this->Places.size());
    }
  }
  std::size_t FirstBelow(PieceId piece) const
  {
    const unsigned below = this->Depth - DepthOfNode(piece.node);
    std::size_t first = notTapped;
    for (auto tap = this->Places.lower_bound(piece.node << below);
         tap != this->Places.end() && tap->first >> below == piece.node; ++tap)
    {
      first = std::min(first, tap->second);
    }
    return first;
  }

private:
  unsigned Depth;
  std::map<NodeId, std::size_t> Places; // position in the list, by node
};

}

using protocol::BlobId;

void LodSelection::Reset()
{
  this->Chooser.reset();
  this->MissingTree.clear();
  this->Last.reset();
  this->ChoiceIsDue = false;
}

void LodSelection::Open()
{
  const ModelDescription& model = this->Model.open->description;
  this->Chooser.emplace(Choosers{ LevelPolicy(LevelFactsOf(model), this->Options.policy),
    ViewRefinement(model, this->Options.refinement),
    ViewRefinement(model, this->Options.refinement), VisiblePartitions(model.depths) });
  this->AimAtPreview();
}

void LodSelection::SetDetail(DetailMode detail)
{
  this->Options.detail = detail;
  this->ChoiceIsDue = false;
  this->Last.reset();
}

void LodSelection::SetBudgets(const RefinementOptions& refinement, const LevelPolicyOptions& policy)
{
  this->Options.refinement = refinement;
  this->Options.policy = policy;
  if (this->Chooser)
  {
    const ModelDescription& model = this->Model.open->description;
    this->Chooser->policy = LevelPolicy(LevelFactsOf(model), policy);
    this->Chooser->refinement = this->Chooser->next = ViewRefinement(model, refinement);
    this->Last.reset();
  }
}

void LodSelection::FollowZoom(double pointsPerUnit)
{
  if (this->Chooser)
  {
    this->Target = this->Chooser->policy.Choose(pointsPerUnit, this->Target);
  }
}

void LodSelection::AimAtPreview()
{
  if (this->Chooser)
  {
    this->Target = this->Chooser->policy.PreviewLevel();
  }
}

void LodSelection::Add(const Piece& piece)
{
  if (this->ByView())
  {
    this->Chooser->seen.Add(piece);
  }
}

// ---- the wish

void LodSelection::Follow(const View& view)
{
  KnownTree& tree = this->Model.open->tree;
  this->MissingTree = tree.TakeMissing();
  if (this->ByView())
  {
    this->Refine(view);
  }
  else if (this->Options.detail == DetailMode::Level && view.isFullScreen)
  {
    this->FollowLevel(view.camera);
  }
  this->MissingTree.merge(tree.TakeMissing());
  if (this->Model.tiles.AreThere() && !view.previewsOnly)
  {
    this->FollowTiles(view);
  }

  const FailedBlobs& failed = this->Model.failed;
  Situation now{ this->Wish(view), view.region, this->MissingTree, this->Model.tiles.Missing(),
    failed.Pieces(), failed.Tree(), this->Model.pieces.Version() };
  if (this->Last != now)
  {
    this->Last = std::move(now);
    this->ChoiceIsDue = true;
  }
}

ViewRefinement::View LodSelection::ViewOf(const Camera& camera, bool inSteps)
{
  const bool isCloud = this->Model.open->description.triangles == 0; // points hide nothing
  return { camera, this->Model.open->tree, this->Model.pieces,
    isCloud ? nullptr : &this->Chooser->seen, inSteps, this->Model.Plane() };
}

void LodSelection::Refine(const View& view)
{
  ViewRefinement& refinement = this->Chooser->refinement;
  if (!view.isFullScreen || this->Model.surface.IsEmpty() || view.previewsOnly)
  {
    refinement.Reset();
    return;
  }
  FailedBlobs& failed = this->Model.failed;
  this->Chooser->seen.Cull(view.camera, this->Model.open->isClosed);
  refinement.Follow(this->ViewOf(view.camera, view.inSteps), view.tapped, failed.Pieces());
  failed.ReportMissed([&](PieceId piece) { return refinement.IsMissed(piece); });
}

// Prepares for a tap when the user has zoomed in: the pages that describe visible pieces up to the
// level that the zoom asks for.
void LodSelection::FollowLevel(const Camera& camera)
{
  if (this->Model.open->description.detail != ModelDetail::Preview)
  {
    const unsigned onePiece = this->Model.Depths().onePiece;
    this->Model.open->tree.Walk([&](NodeId page, const Box& box)
      { return page == 1 || (onePiece + DepthOfNode(page) < this->Target && camera.MaySee(box)); });
  }
}

// Chooses the tiles of the surface that is drawn.
void LodSelection::FollowTiles(const View& view)
{
  std::set<NodeId> tapped;
  for (const PieceId piece : view.tapped)
  {
    tapped.insert(piece.node);
  }
  const bool all = this->Options.detail == DetailMode::Full;
  std::vector<PieceId> levels; // ascending, because no wanted piece is coarser than the preview
  if (this->ByView())
  {
    levels.push_back(this->Model.Preview());
    levels.insert(levels.end(), this->WantedByView().begin(), this->WantedByView().end());
  }
  this->Model.tiles.Follow(
    this->Model.Drawn(), view.camera, tapped, all, this->ByView() ? &levels : nullptr);
}

// The level that the zoom asks for, or the next coarser one of which no piece has failed.
unsigned LodSelection::EffectiveLevel() const
{
  unsigned level = this->Target;
  const auto failed = [this](unsigned d)
  {
    const std::set<PieceId>& pieces = this->Model.failed.Pieces();
    const auto first = pieces.lower_bound({ Resolution::Level(d), 0 });
    return first != pieces.end() && first->resolution == Resolution::Level(d);
  };
  while (level > this->Chooser->policy.PreviewLevel() && failed(level))
  {
    --level;
  }
  return level;
}

SurfaceWish LodSelection::Wish(const View& view) const
{
  const Resolution preview = this->Model.Preview().resolution;
  if (this->Model.surface.IsEmpty()) // nothing but the preview is requested first
  {
    return { preview, {} };
  }
  switch (this->Options.detail)
  {
    case DetailMode::View:
    {
      SurfaceWish wish{ preview, this->WantedByView() };
      wish.pieces.insert(wish.pieces.end(), view.tapped.begin(), view.tapped.end());
      return wish;
    }
    case DetailMode::Level:
      return { Resolution::Level(this->EffectiveLevel()), view.tapped };
    case DetailMode::Full:
      break;
  }
  return { view.isFullScreen ? Resolution::Original() : preview, {} };
}

// ---- the choice

std::optional<std::vector<BlobId>> LodSelection::Choose(const View& view)
{
  this->ChoiceIsDue = false;
  ++this->ChoicesMade;
  ShownSurface& surface = this->Model.surface;
  PieceCache& pieces = this->Model.pieces;
  const bool wasEmpty = surface.IsEmpty();
  ShownSurface::Needs needs =
    this->ByView() ? surface.ShowLoaded(this->Wish(view), pieces)
                   : surface.ShowWhole(this->Wish(view), pieces, this->Model.failed.Pieces());
  if (wasEmpty && !surface.IsEmpty())
  {
    return std::nullopt;
  }
  std::vector<BlobId> order = this->InOrder(view, needs.missing);
  needs.all.insert(surface.Pieces().begin(), surface.Pieces().end());
  pieces.Pin(std::move(needs.all));
  return order;
}

// In level and full mode, the preview comes first as long as nothing is shown.
std::vector<BlobId> LodSelection::InOrder(const View& view, const std::vector<PieceId>& missing)
{
  const FailedBlobs& failed = this->Model.failed;
  const TreeDepths& depths = this->Model.Depths();
  const bool previewFirst = !this->ByView() && this->Model.surface.IsEmpty();
  std::vector<BlobId> order;
  const Taps taps(view.tapped, depths);
  struct Entry
  {
    std::size_t tap;
    double urgency;
    PieceId piece;
  };
  std::vector<Entry> entries;
  for (const PieceId piece : missing)
  {
    if (previewFirst && piece == this->Model.Preview() && !failed.Has(piece))
    {
      order.push_back(this->Model.PreviewBlob());
    }
    else if (!failed.Has(piece))
    {
      const std::size_t tap = view.tapped.empty() ? notTapped : taps.FirstBelow(piece);
      const bool isUrgent = this->ByView() && tap == notTapped;
      entries.push_back({ tap,
        isUrgent ? this->Chooser->refinement.UrgencyOf(piece, view.camera, this->Model.open->tree)
                 : 0,
        piece });
    }
  }
  std::copy_if(this->MissingTree.begin(), this->MissingTree.end(), std::back_inserter(order),
    [&](const BlobId& blob) { return !failed.Has(blob); });
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
  const std::vector<BlobId>& tiles = this->Model.tiles.Missing();
  order.insert(order.end(), tiles.begin(), tiles.end());
  return order;
}

std::vector<BlobId> LodSelection::WantedNext(const View& view)
{
  const FailedBlobs& failed = this->Model.failed;
  KnownTree& tree = this->Model.open->tree;
  ViewRefinement& next = this->Chooser->next;
  Camera nearer = view.camera;
  const Viewport& screen = nearer.GetViewport();
  nearer.Zoom(nearerNext, 0.5 * screen.width, 0.5 * screen.height);
  next.Follow(this->ViewOf(nearer, false), view.tapped, failed.Pieces());
  std::vector<BlobId> order;
  for (const BlobId& blob : tree.TakeMissing())
  {
    if (!failed.Has(blob))
    {
      order.push_back(blob);
    }
  }
  std::vector<std::pair<double, PieceId>> pieces;
  const Closure closure = MakeClosure(this->Model.Depths(), this->Model.Preview().resolution,
    next.Pieces(), [this](PieceId id) { return this->Model.pieces.Peek(id); });
  for (const PieceId piece : closure.missing)
  {
    if (!failed.Has(piece))
    {
      pieces.emplace_back(-next.UrgencyOf(piece, nearer, tree), piece);
    }
  }
  std::sort(pieces.begin(), pieces.end());
  for (const auto& [urgency, piece] : pieces)
  {
    order.push_back(BlobOfPiece(piece, this->Model.Depths()));
  }
  return order;
}

std::size_t LodSelection::BytesOf(const BlobId& blob) const
{
  if (IsOfTexture(blob))
  {
    return this->Model.tiles.ExpectedBytes(blob);
  }
  return IsOfPiece(blob) ? this->Chooser->refinement.BlobBytes(
                             PieceOfBlob(blob, this->Model.Depths()), this->Model.open->tree)
                         : bytesOfTreeBlob;
}

bool LodSelection::WaitsForTree() const
{
  return std::any_of(this->MissingTree.begin(), this->MissingTree.end(),
    [this](const BlobId& blob) { return !this->Model.failed.Has(blob); });
}

void LodSelection::PutInto(ViewerStatus& status) const
{
  if (this->Chooser)
  {
    const ViewRefinement& refinement = this->Chooser->refinement;
    status.remainingError = this->ByView() ? refinement.RemainingError() : 0;
    status.targetLevel = this->ByView() ? this->Model.LevelOf(refinement.Finest()) : this->Target;
  }
  const ShownSurface& surface = this->Model.surface;
  if (this->ByView() && surface.Finest())
  {
    status.original = surface.Finest()->IsOriginal();
    status.shownLevel = this->Model.LevelOf(*surface.Finest());
  }
  else if (!this->ByView() && surface.GetCut())
  {
    status.shownLevel = this->Model.LevelOf(surface.GetCut()->base);
  }
}

}
