// SPDX-License-Identifier: BSD-3-Clause
// View-dependent refinement: chooses the pieces of a view, the largest screen-space error first.
// Step "choose" of the pipeline picture; described in doc/viewing.md.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/session/Camera.h"
#include "viewer/session/SessionOptions.h"
#include "viewer/session/model/KnownTree.h"
#include "viewer/session/model/PieceCache.h"
#include "viewer/session/model/VisiblePartitions.h"
#include "viewer/session/section/SectionPlane.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

namespace kdstream
{

// Light and colour are values at the vertices, interpolated between them: variations between
// vertices are lost, however exact the surface is. So the error of a piece is at least this part of
// the distance between its vertices (decision 6): a sixth for the normals; a third if the model has
// vertex colours; a half if only its original has textures, which have more detail than vertices; a
// seventh if levels have textures too: texels show what vertices would, in fewer bytes (decision
// 41).
double LightPartOf(const ModelDescription& model);

// About the distance of neighbouring vertices of a surface in a box, if they are spread over half
// the box's surface. Model units.
double VertexSpacing(const Box& box, double vertices);

// Walks down from the preview, the most urgent piece first. A piece is wanted if the coarser piece
// above it would show a visible error in the box of the piece. The error is the larger of two
// values: the geometric error that 99 of 100 vertices do not exceed, and what light and colour need
// (decision 6); as seen from the nearest point of the box. Invisible pieces are not wanted. The
// finest pieces are the original's.
//
// A step from one resolution to the next doubles the triangles. The step to the original may be
// larger, up to six times. If it multiplies the triangles by 2 f, its tolerance is multiplied by
// f^(3/8), so that additional triangles gain as much as elsewhere (measured on the dragon); by
// f^(3/2) if levels have textures, because then triangles gain less (decision 41).
//
// The urgency of a piece is its error in points, in the middle of the screen; half of that at the
// upper and lower edges. It is never more than that of the piece above it.
//
// On each way down only the last piece is wanted; MakeClosure adds the pieces above it, down to
// level S, that are needed to show it. If the last piece is finer than S and far below what is
// loaded, one piece in between is wanted too. Until a piece arrives, the finest loaded one above it
// is shown.
//
// If a piece has failed, the one above it is wanted. The search continues below a failed piece
// where finer pieces can be shown without it: finer than S. There one step is searched even if
// nothing finer is needed, because without a server such a piece may be on the disk.
//
// The walk always ends, whatever the server sends: at the original, or at a budget.
class ViewRefinement
{
public:
  // REQUIRES: a model with levels.
  ViewRefinement(const ModelDescription& model, const RefinementOptions& options);

  struct View
  {
    const Camera& camera;
    KnownTree& tree;
    const PieceCache& loaded;
    const VisiblePartitions* seen = nullptr; // null: everything may be visible
    bool inSteps = true;                     // fine pieces are preceded by one intermediate piece
    const SectionPlane* section = nullptr;   // the section that cuts parts away
  };
  // Finds what is wanted. `first`: partitions that are wanted in any case; budgets serve them
  // first. `failed`: pieces that cannot be fetched. The tree records as missing which pages are
  // needed to continue. O(p log p) for p wanted pieces.
  void Follow(const View& view, std::span<const PieceId> first, const std::set<PieceId>& failed);
  // Only the preview is wanted.
  void Reset();

  // The wanted pieces, ascending, without those that are wanted anyway; and their substitutes.
  const std::vector<PieceId>& Pieces() const { return this->Wanted; }
  // The finest resolution among them; the preview's if there is none.
  Resolution Finest() const;
  // The largest error, in points, that was left because of a budget; 0 if everything was refined.
  double RemainingError() const { return this->Left; }

  // Whether a failed piece is not needed, because it can be shown otherwise.
  bool MayDoWithout(PieceId piece) const
  {
    return this->IsIntermediate(this->StepOf(piece.resolution));
  }
  // Whether the lack of this piece leaves something coarser than the view needs: the piece is in
  // the view, and the pieces below it do not all replace it, now or later.
  bool IsMissed(PieceId piece) const { return this->Missed.count(piece) > 0; }

  // How urgent a piece is, wanted or not: a visible neighbour may need a piece that is not in view.
  // 0 if too little of the tree is known.
  double UrgencyOf(PieceId piece, const Camera& camera, KnownTree& tree) const;

  // About how many bytes the blob of a piece has.
  std::size_t BlobBytes(PieceId piece, KnownTree& tree) const;
  // About how much memory a piece takes, decoded and drawn.
  std::size_t MemoryOf(PieceId piece) const;

private:
  // A resolution that may be shown: the preview, what is finer, the original.
  struct Step
  {
    Resolution resolution;
    unsigned depth = 0;   // depth of its pieces in the tree
    double triangles = 0; // average triangles of a piece; points for a cloud
    double vertices = 0, blob = 0, memory = 0;
    double leap = 1; // the piece is taken at an error larger by this factor
  };
  struct Candidate
  {
    double urgency = 0, error = 0;
    std::size_t step = 0;
    NodeId node = 1;
    PieceId above; // the piece that this candidate would replace
    // The most urgent, and of equals the coarsest and first, is on top of a heap.
    bool operator<(const Candidate& other) const;
  };
  struct Walk;

  std::size_t StepOf(Resolution resolution) const;
  // Finer than S, but not the finest: pieces below can be shown without such a piece.
  bool IsIntermediate(std::size_t step) const
  {
    return step > this->Stitch && step + 1 < this->Allowed;
  }
  bool NeedsSubstitute(const Walk& walk, std::size_t step, NodeId node) const;
  std::optional<double> GeometricErrorOf(std::size_t step, NodeId node, KnownTree& tree) const;
  double ErrorIn(const Box& box, double geometricError, const Camera& camera) const;
  static double Weight(const Box& box, const Camera& camera);
  bool MayBeVisible(Walk& walk, NodeId node) const;
  void PushBelow(Walk& walk, std::size_t step, NodeId node, double urgency) const;
  void Want(PieceId piece, double urgency);
  void FindWhatIsMissed(Walk& walk);
  void WantWhatIsLeft(const Walk& walk);
  void WantIntermediate(PieceId piece, const View& view, const std::set<PieceId>& failed);
  PieceId Above(PieceId piece, std::size_t step) const; // the piece of a coarser step

  RefinementOptions Options;
  TreeDepths Depths;
  std::size_t Stitch; // the step of level S, or 0
  double LightPart;   // this part of the distance between vertices counts as an error
  double Smallest;    // least distance from the eye that is used, model units
  std::vector<Step> Steps;
  std::size_t Allowed = 0;   // number of resolutions that this client may get
  std::set<PieceId> Refined; // with each piece also those above it
  std::set<PieceId> Missed;  // of these, the pieces that cannot be fetched
  std::vector<PieceId> Wanted;
  std::map<PieceId, double> Urgencies; // of the wanted pieces
  double Left = 0;
};

}
