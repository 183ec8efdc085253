// SPDX-License-Identifier: BSD-3-Clause
// Which vertices of a cut's pieces are shown, and which vertices show the others. Only for
// SurfaceParts.cxx.
#pragma once

#include "filters/core/drawing/Cut.h"
#include "filters/core/drawing/ParentSurface.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// Finds the node of the cut above every vertex of its pieces. Pieces are processed from coarse to
// fine. The parent of a cluster, an own vertex of a coarser piece, decides whether the cluster is
// reached. If the parent's piece is not in the cut, the parent is not split, and not reached unless
// it is of the base; then the finest ancestor whose piece is in the cut decides. For pieces that
// contradict each other the result is some map, too.
//
// Works incrementally from one cut to the next. A piece is processed again only if a piece that its
// vertices depend on was added or removed, or shows other vertices than before. Missing pieces need
// not be remembered: if one is added and shows anything, the ancestor used in its place is split.
class ShownVertices
{
public:
  // pieces: those of PiecesOf(cut), in this order; they must live until the next call. The first
  // call takes O(v log pieces) for v vertices; later calls the same for the pieces that are
  // processed again.
  void GoTo(const Cut& cut, std::vector<const Piece*> pieces);

  const std::vector<const Piece*>& Pieces() const { return this->All; }
  // Whether the i-th piece is new, or some vertex of it is shown by another node than before.
  bool HasChanged(std::size_t i) const { return this->Numbered[i]->changed; }

  // Whether an own vertex or a ghost of the i-th piece is itself in the cut.
  bool IsInCut(std::size_t i, std::uint32_t v) const
  {
    return this->Numbered[i]->shown[v] == this->All[i]->id.resolution;
  }

  // The own vertex of a piece that shows a vertex of piece `i`. Nothing if only finer vertices are
  // shown there, or if pieces contradict each other.
  using Place = ClusterOwners::Place;
  std::optional<Place> NodeAbove(std::size_t i, std::uint32_t v);

  // The nodes above an own vertex of piece `i`, as far as the pieces know them.
  Lineage LineageOf(std::size_t i, std::uint32_t v);

private:
  // In lists of resolutions, for vertices above the cut: finer than every level.
  static constexpr Resolution above = Resolution::Level(Resolution::maximumLevel);

  using Keys = std::vector<std::uint64_t>; // of pieces: KeyOf

  struct Known // of one piece
  {
    std::vector<Resolution> shown; // of its vertices
    // The pieces that were looked at for own vertices, and for ghosts: ascending, each once.
    Keys askedByOwn, askedByGhosts;
    bool changed = true;
  };
  struct Ancestry
  {
    bool parentIsSplit = false;
    Resolution shown; // if the parent is not split
  };

  void TakePieces(std::vector<const Piece*> pieces);
  bool AskOwn(const Piece& piece, Known& known);
  bool AskGhosts(const Piece& piece, Known& known);
  Keys TakeAsked(const Piece& piece);
  Ancestry Ask(const Piece& piece, std::uint32_t v);
  Resolution ShownOwn(const Piece& piece, std::uint32_t v);
  Resolution ShownGhost(const Piece& piece, std::uint32_t v);
  Resolution InPartition(const Piece& piece, std::uint32_t v);
  Resolution FinestOf(std::uint32_t partition) const;
  bool IsSplit(const Piece& piece, std::uint32_t v) const;
  bool IsActive(PieceId id) const;
  Resolution ShownAtPlace(const Place& place);
  std::optional<Place> IntervalAt(Resolution resolution, VertexKey key);
  std::optional<Place> StitchClusterOf(VertexKey key);

  Cut C{ {}, {} };
  Resolution Base, Stitch;
  std::vector<const Piece*> All;
  std::vector<PieceId> Ids;                     // of All, ascending
  std::vector<std::unique_ptr<Known>> Numbered; // one a piece
  ClusterOwners Owners;
  // While a piece is gone through: the pieces, and partitions, that were asked.
  Keys AskedPieces, AskedPartitions;
  std::optional<Place> LastInterval; // that was found; keys are mostly asked in their order
  std::uint32_t LastPartition = 0;
  std::optional<Resolution> LastFinest; // the finest resolution of LastPartition
};

}
