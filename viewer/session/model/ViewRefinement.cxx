// SPDX-License-Identifier: BSD-3-Clause
// Which pieces a view needs: see ViewRefinement.h.
#include "viewer/session/model/ViewRefinement.h"

#include "filters/core/Attribute.h"
#include "viewer/session/Geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace kdstream
{
namespace
{

// Memory for each triangle: in the decoded piece (positions and keys, also of ghosts, ancestors,
// triangles), and in what is drawn and uploaded. TestViewRefinement compares it with
// MemoryOf(Piece).
constexpr double bytesOfTriangle = 120;

bool LevelsHaveTiles(const ModelDescription& model)
{
  return model.textures && model.textures->levels;
}

}

double LightPartOf(const ModelDescription& model)
{
  const bool hasColors = std::any_of(model.attributes.begin(), model.attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  return LevelsHaveTiles(model) ? 1.0 / 7
         : model.textures       ? 1.0 / 2
         : hasColors            ? 1.0 / 3
                                : 1.0 / 6;
}

double VertexSpacing(const Box& box, double vertices)
{
  const Vec3 s = box.hi - box.lo;
  const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
  return std::sqrt(area / std::max(vertices, 1.0));
}

// What is known about the pieces below a refined piece.
struct FoundBelow
{
  double urgency = 0;
  std::size_t seen = 0;    // pieces below it that are in view
  std::size_t refined = 0; // visible child pieces that replace it
};

struct ViewRefinement::Walk
{
  const View& view;
  const std::set<PieceId>& failed;
  const std::set<PieceId> before; // pieces that were refined before
  std::priority_queue<Candidate> waiting;
  std::map<PieceId, FoundBelow> found;
  std::map<NodeId, bool> seen; // by node: whether it may be visible
  std::set<NodeId> pages;      // pages of pieces that were refined
};

bool ViewRefinement::Candidate::operator<(const Candidate& other) const
{
  if (this->urgency != other.urgency)
  {
    return this->urgency < other.urgency;
  }
  return this->step != other.step ? this->step > other.step : this->node > other.node;
}

ViewRefinement::ViewRefinement(const ModelDescription& model, const RefinementOptions& options)
  : Options(options)
  , Depths(model.depths)
  , Stitch(0)
  , LightPart(LightPartOf(model))
  , Smallest(std::max(Length(model.box.hi - model.box.lo) * 1e-6, 1e-300))
{
  if (std::max(model.triangles, model.vertices) <= options.smallModel)
  {
    this->Options.tolerance /= 4;
  }
  const bool isCloud = model.triangles == 0;
  const auto add = [this, isCloud](Resolution resolution, const ResolutionDescription& facts)
  {
    const unsigned depth = PieceDepth(resolution, this->Depths);
    const double pieces = std::ldexp(1.0, static_cast<int>(depth));
    const auto drawn = static_cast<double>(isCloud ? facts.vertices : facts.triangles);
    this->Steps.push_back({ resolution, depth, drawn / pieces,
      static_cast<double>(facts.vertices) / pieces, static_cast<double>(facts.bytes) / pieces,
      bytesOfTriangle *
        std::max(static_cast<double>(facts.triangles), 2.0 * static_cast<double>(facts.vertices)) /
        pieces });
  };
  for (unsigned level = PreviewLevel(this->Depths); level <= this->Depths.finest; ++level)
  {
    add(Resolution::Level(level), model.levels[level]);
  }
  add(Resolution::Original(), model.original);
  for (std::size_t i = 1; i < this->Steps.size(); ++i)
  {
    const Step& above = this->Steps[i - 1];
    const double pieces =
      std::ldexp(1.0, static_cast<int>(this->Steps[i].depth) - static_cast<int>(above.depth));
    const double leap =
      this->Steps[i].vertices * pieces / std::max(above.vertices, 1.0) / 2; // 1: twice as many
    const double much = std::max(leap, 1.0);
    const double root = LevelsHaveTiles(model) ? much : std::sqrt(std::sqrt(much));
    this->Steps[i].leap = root * std::sqrt(root); // much^(3/2) or much^(3/8)
  }
  this->Allowed = model.detail == ModelDetail::Regions  ? this->Steps.size()
                  : model.detail == ModelDetail::Levels ? this->Steps.size() - 1
                                                        : 1;
  this->Stitch = this->Depths.stitch > PreviewLevel(this->Depths)
                   ? this->StepOf(Resolution::Level(this->Depths.stitch))
                   : 0;
}

void ViewRefinement::Reset()
{
  this->Refined.clear();
  this->Missed.clear();
  this->Wanted.clear();
  this->Urgencies.clear();
  this->Left = 0;
}

std::size_t ViewRefinement::StepOf(Resolution resolution) const
{
  return resolution.IsOriginal()
           ? this->Steps.size() - 1
           : resolution.Depth() - std::size_t{ this->Steps.front().resolution.Depth() };
}

// The error of a piece in model units: the larger of its geometric error and that of interpolating
// light and colour between vertices.
std::optional<double> ViewRefinement::GeometricErrorOf(
  std::size_t step, NodeId node, KnownTree& tree) const
{
  const PieceId piece{ this->Steps[step].resolution, node };
  const PieceFacts* facts = tree.FactsOf(piece);
  const double most = facts ? facts->most99 : 0;
  const Box* box = facts ? tree.Around(node) : nullptr;
  if (!box)
  {
    tree.NeedFactsOf(piece);
    return {};
  }
  return std::max(most, this->LightPart * VertexSpacing(*box, this->Steps[step].vertices));
}

double ViewRefinement::ErrorIn(const Box& box, double geometricError, const Camera& camera) const
{
  return geometricError * camera.PointsPerUnit(std::max(camera.DistanceTo(box), this->Smallest));
}

double ViewRefinement::Weight(const Box& box, const Camera& camera)
{
  const double away = camera.Eccentricity(box.lo * 0.5 + box.hi * 0.5);
  return 1 / (1 + std::min(away * away, 100.0));
}

// Whether anything in a node may be visible. A box is mostly empty, so the boxes inside it decide,
// where they are known.
bool ViewRefinement::MayBeVisible(Walk& walk, NodeId node) const
{
  const auto known = walk.seen.find(node);
  if (known != walk.seen.end())
  {
    return known->second;
  }
  const View& view = walk.view;
  const Box* box = view.tree.Around(node);
  const bool isGone = box && view.section && view.section->CutsAwayAllOf(*box);
  bool may = !box || (view.camera.MaySee(*box) && !isGone);
  if (may && box && DepthOfNode(node) < this->Depths.partition && view.tree.Around(2 * node))
  {
    may = this->MayBeVisible(walk, 2 * node) || this->MayBeVisible(walk, 2 * node + 1);
  }
  else if (may && view.seen)
  {
    may = view.seen->MayBeVisible(node);
  }
  walk.seen.emplace(node, may);
  return may;
}

// Whether finer pieces should replace a failed piece. Only one step finer: otherwise, without a
// server, the search would go through everything that was never loaded.
bool ViewRefinement::NeedsSubstitute(const Walk& walk, std::size_t step, NodeId node) const
{
  const PieceId piece{ this->Steps[step].resolution, node };
  return this->IsIntermediate(step) && walk.failed.count(piece) != 0 &&
         walk.failed.count(this->Above(piece, step - 1)) == 0;
}

// Pushes the candidates that would replace a piece.
void ViewRefinement::PushBelow(Walk& walk, std::size_t step, NodeId node, double urgency) const
{
  if (step + 1 >= this->Allowed)
  {
    return;
  }
  const View& view = walk.view;
  walk.pages.insert(TreePageOfNode(node, this->Depths));
  if (walk.pages.size() > view.tree.MostPages() / 2)
  {
    return; // more pages would evict needed ones
  }
  const auto geometricError = this->GeometricErrorOf(step, node, view.tree);
  if (!geometricError)
  {
    return;
  }
  const PieceId above{ this->Steps[step].resolution, node };
  const PieceId teller = this->Above(above, std::min(step, this->Stitch));
  const bool isReported = view.seen && view.seen->Knows(teller);
  if (view.seen && !isReported && !view.loaded.Peek(teller))
  {
    walk.found[above].seen = 1; // that piece will show which ones below may be visible
    return;
  }
  const Step& next = this->Steps[step + 1];
  const unsigned deeper = next.depth - this->Steps[step].depth;
  const bool substitute = this->NeedsSubstitute(walk, step, node);
  for (NodeId i = 0; i < NodeId{ 1 } << deeper; ++i)
  {
    const PieceId below{ next.resolution, (node << deeper) + i };
    const Box* box = view.tree.Around(below.node);
    if (!box)
    {
      view.tree.NeedAround(below.node);
      ++walk.found[above].seen; // counts as visible
    }
    else if (this->MayBeVisible(walk, below.node) &&
             (!isReported || step >= this->Stitch || view.seen->MayBeVisible(below)))
    {
      ++walk.found[above].seen;
      const double bonus = walk.before.count(below) != 0 ? this->Options.deadBand : 1;
      const double error = this->ErrorIn(*box, *geometricError, view.camera);
      const double own = error * Weight(*box, view.camera) * bonus;
      const double tolerance = this->Options.tolerance * next.leap;
      const bool mayBeHad = this->IsIntermediate(step + 1) || walk.failed.count(below) == 0;
      if ((error * bonus > tolerance || substitute) && mayBeHad)
      {
        walk.waiting.push({ std::min(own, urgency), error, step + 1, below.node, above });
      }
    }
  }
}

void ViewRefinement::Follow(
  const View& view, std::span<const PieceId> first, const std::set<PieceId>& failed)
{
  Walk walk{ view, failed, std::exchange(this->Refined, {}), {}, {}, {}, {} };
  this->Reset();
  const Step &root = this->Steps.front(), &original = this->Steps.back();
  const auto given = static_cast<double>(first.size());
  double triangles = root.triangles + given * original.triangles;
  double memory = root.memory + given * original.memory;
  this->PushBelow(walk, 0, 1, std::numeric_limits<double>::infinity());
  while (!walk.waiting.empty())
  {
    const Candidate next = walk.waiting.top();
    walk.waiting.pop();
    const Step &step = this->Steps[next.step], &above = this->Steps[next.step - 1];
    const double share =
      std::ldexp(1.0, static_cast<int>(above.depth) - static_cast<int>(step.depth));
    triangles += step.triangles - share * above.triangles;
    memory += step.memory - (next.step - 1 > this->Stitch ? share * above.memory : 0);
    if (triangles > static_cast<double>(this->Options.triangles) ||
        memory > static_cast<double>(this->Options.bytes))
    {
      this->Left = next.error;
      for (; !walk.waiting.empty(); walk.waiting.pop())
      {
        this->Left = std::max(this->Left, walk.waiting.top().error);
      }
      break;
    }
    const PieceId piece{ step.resolution, next.node };
    this->Refined.insert(piece);
    walk.found[piece].urgency = next.urgency;
    walk.found[next.above].refined += walk.failed.count(piece) == 0 ? 1 : 0;
    this->PushBelow(walk, next.step, next.node, next.urgency);
  }
  this->FindWhatIsMissed(walk);
  this->WantWhatIsLeft(walk);
}

// Finds the failed pieces that the view misses. A failed piece is not missed if all pieces below it
// that may be visible can be fetched.
void ViewRefinement::FindWhatIsMissed(Walk& walk)
{
  for (auto piece = this->Refined.rbegin(); piece != this->Refined.rend(); ++piece) // finest first
  {
    if (walk.failed.count(*piece) == 0)
    {
      continue;
    }
    const FoundBelow& found = walk.found.at(*piece);
    if (found.refined < found.seen || found.seen == 0)
    {
      this->Missed.insert(*piece);
    }
    else
    {
      ++walk.found[this->Above(*piece, this->StepOf(piece->resolution) - 1)].refined;
    }
  }
}

// Wants those refined pieces that finer pieces do not replace completely.
void ViewRefinement::WantWhatIsLeft(const Walk& walk)
{
  for (const PieceId piece : this->Refined)
  {
    if (walk.failed.count(piece) != 0)
    {
      continue;
    }
    const FoundBelow& found = walk.found.at(piece);
    const bool isLast = this->StepOf(piece.resolution) + 1 >= this->Allowed;
    if (found.refined < found.seen || isLast)
    {
      this->Want(piece, found.urgency);
      if (this->StepOf(piece.resolution) > this->Stitch)
      {
        this->WantIntermediate(piece, walk.view, walk.failed);
      }
    }
  }
  std::sort(this->Wanted.begin(), this->Wanted.end());
}

void ViewRefinement::Want(PieceId piece, double urgency)
{
  if (this->Urgencies.emplace(piece, urgency).second)
  {
    this->Wanted.push_back(piece);
  }
}

// Until a wanted piece finer than S arrives, also wants the loaded pieces below it, and the finest
// loaded piece above it. If none is loaded between it and S, a piece three steps coarser is fetched
// first (View::inSteps).
void ViewRefinement::WantIntermediate(
  PieceId piece, const View& view, const std::set<PieceId>& failed)
{
  if (view.loaded.Peek(piece))
  {
    return;
  }
  const std::size_t step = this->StepOf(piece.resolution);
  for (std::size_t below = step + 1; below < this->Steps.size(); ++below)
  {
    const unsigned deeper = this->Steps[below].depth - this->Steps[step].depth;
    for (NodeId i = 0; i < NodeId{ 1 } << deeper; ++i)
    {
      const PieceId substitute{ this->Steps[below].resolution, (piece.node << deeper) + i };
      if (view.loaded.Peek(substitute))
      {
        this->Want(substitute, 0);
      }
    }
  }
  for (std::size_t above = step - 1; above > this->Stitch; --above)
  {
    const PieceId substitute = this->Above(piece, above);
    if (view.loaded.Peek(substitute))
    {
      this->Want(substitute, 0);
      return;
    }
  }
  constexpr std::size_t stepsAtOnce = 3;
  if (view.inSteps && step > this->Stitch + stepsAtOnce)
  {
    const PieceId first = this->Above(piece, step - stepsAtOnce);
    if (failed.count(first) == 0)
    {
      this->Want(first, this->UrgencyOf(first, view.camera, view.tree));
    }
  }
}

PieceId ViewRefinement::Above(PieceId piece, std::size_t step) const
{
  const unsigned deeper =
    this->Steps[this->StepOf(piece.resolution)].depth - this->Steps[step].depth;
  return { this->Steps[step].resolution, piece.node >> deeper };
}

Resolution ViewRefinement::Finest() const
{
  return this->Wanted.empty() ? this->Steps.front().resolution : this->Wanted.back().resolution;
}

double ViewRefinement::UrgencyOf(PieceId piece, const Camera& camera, KnownTree& tree) const
{
  const auto wanted = this->Urgencies.find(piece);
  if (wanted != this->Urgencies.end())
  {
    return wanted->second;
  }
  const std::size_t step = this->StepOf(piece.resolution);
  const Box* box = tree.Around(piece.node);
  const PieceFacts* facts =
    step > 0 ? tree.FactsOf({ this->Steps[step - 1].resolution, this->Above(piece, step - 1).node })
             : nullptr;
  if (!box || !facts)
  {
    return step > 0 ? 0 : std::numeric_limits<double>::infinity();
  }
  const auto geometricError =
    this->GeometricErrorOf(step - 1, this->Above(piece, step - 1).node, tree);
  return geometricError ? this->ErrorIn(*box, *geometricError, camera) * Weight(*box, camera) : 0;
}

std::size_t ViewRefinement::BlobBytes(PieceId piece, KnownTree& tree) const
{
  const PieceFacts* facts = tree.FactsOf(piece);
  return facts ? facts->bytes
               : static_cast<std::size_t>(this->Steps[this->StepOf(piece.resolution)].blob);
}

std::size_t ViewRefinement::MemoryOf(PieceId piece) const
{
  return static_cast<std::size_t>(this->Steps[this->StepOf(piece.resolution)].memory);
}

}
