// SPDX-License-Identifier: BSD-3-Clause
// LOD selection: which pieces of the open model are wanted, which of them are shown, and which are
// missing, most urgent first. Step "choose" of the pipeline picture.
#pragma once

#include "viewer/session/model/LevelPolicy.h"
#include "viewer/session/model/ShownModel.h"
#include "viewer/session/model/ViewRefinement.h"
#include "viewer/session/model/VisiblePartitions.h"

#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace kdstream
{

// In view mode the wish is given by ViewRefinement. In level mode it is the level that the zoom
// asks for, or the next coarser one of which no piece has failed. In full mode it is all of the
// original. Tapped regions are always wanted. In view mode whatever has arrived is shown; in level
// mode a level is shown when it is whole.
//
// Most inputs only move the camera, and visiting every vertex of the wanted pieces at each would be
// too slow. So Follow, which is fast, finds out whether a new choice is needed (IsDue).
class LodSelection
{
public:
  // The inputs of the selection.
  struct View
  {
    const Camera& camera;
    bool isFullScreen = false;
    bool previewsOnly = false;     // nothing finer is wanted
    bool inSteps = true;           // as in ViewRefinement::View
    std::vector<PieceId> tapped{}; // of the original, wanted before all else, most urgent first
    std::pair<NodeId, unsigned> region{}; // around a tap: its cell, or 0, and rings
  };

  LodSelection(ShownModel& model, const LodOptions& options)
    : Model(model)
    , Options(options)
  {
  }
  LodSelection(const LodSelection&) = delete;

  void Reset(); // no model is open
  void Open();  // a model is open
  const LodOptions& GetOptions() const { return this->Options; }
  bool ByView() const { return this->Options.detail == DetailMode::View; }
  void SetDetail(DetailMode detail);
  void SetBudgets(const RefinementOptions& refinement, const LevelPolicyOptions& policy);

  // In level mode: chooses the level by the zoom. pointsPerUnit: points of the screen for one model
  // unit in the focal plane.
  void FollowZoom(double pointsPerUnit);
  void AimAtPreview();

  // A piece has arrived.
  void Add(const Piece& piece);
  // Finds the wanted pieces, and the missing pages of the tree and textures.
  void Follow(const View& view);
  // Whether anything that the choice depends on has changed since the last choice.
  bool IsDue() const { return this->ChoiceIsDue; }
  void SetDue() { this->ChoiceIsDue = true; }
  // Shows the best that is loaded. Returns what is missing and can be fetched, most urgent first:
  // 1. pages of the tree, on which all choices depend;
  // 2. what each tapped partition needs, and the partition;
  // 3. the most urgent pieces, coarse before fine by one level;
  // 4. textures of what is loaded.
  //
  // Nothing if the preview has just appeared: then Follow must be called again.
  std::optional<std::vector<protocol::BlobId>> Choose(const View& view);

  // The missing blobs of a nearer view, the tree first, then the most urgent.
  std::vector<protocol::BlobId> WantedNext(const View& view);
  // The approximate size of a blob that has not arrived.
  std::size_t BytesOf(const protocol::BlobId& blob) const;
  // Whether a part of the tree that is needed now is missing and can be fetched.
  bool WaitsForTree() const;
  // Whether the view can do without this failed piece (ViewRefinement).
  bool MayDoWithout(PieceId piece) const
  {
    return this->ByView() && this->Chooser->refinement.MayDoWithout(piece);
  }

  const std::vector<PieceId>& WantedByView() const { return this->Chooser->refinement.Pieces(); }
  // Fills in its part of ViewerStatus; nothing before a model is open.
  void PutInto(ViewerStatus& status) const;
  // How often Choose was called.
  std::uint64_t Choices() const { return this->ChoicesMade; }

private:
  // Everything on which a choice depends.
  struct Situation
  {
    SurfaceWish wish;
    std::pair<NodeId, unsigned> region;
    std::set<protocol::BlobId> tree;     // missing pages of the tree
    std::vector<protocol::BlobId> tiles; // missing tiles
    std::set<PieceId> failedPieces;
    std::set<protocol::BlobId> failedTree;
    std::uint64_t pieces = 0; // version of the cached pieces
    bool operator==(const Situation&) const = default;
  };
  struct Choosers
  {
    LevelPolicy policy;
    ViewRefinement refinement, next; // for the view, and for a nearer view
    VisiblePartitions seen;
  };

  ViewRefinement::View ViewOf(const Camera& camera, bool inSteps);
  void Refine(const View& view);
  void FollowLevel(const Camera& camera);
  void FollowTiles(const View& view);
  unsigned EffectiveLevel() const;
  SurfaceWish Wish(const View& view) const;
  std::vector<protocol::BlobId> InOrder(const View& view, const std::vector<PieceId>& missing);

  ShownModel& Model;
  LodOptions Options;
  std::optional<Choosers> Chooser;        // of the model that is open
  unsigned Target = 0;                    // level that the zoom asks for
  std::set<protocol::BlobId> MissingTree; // missing pages for the current view
  std::optional<Situation> Last;          // the last situation that was followed
  bool ChoiceIsDue = false;
  std::uint64_t ChoicesMade = 0;
};

}
