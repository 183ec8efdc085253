// SPDX-License-Identifier: BSD-3-Clause
// Which vertices of a cut's pieces are shown, and by what the others are: for SurfaceParts.cxx
// alone.
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

// Finds the node of the cut above every vertex of its pieces. Pieces are gone through from coarse
// to fine: whether a cluster is reached its parent knows, which is an own vertex of a coarser
// piece. Where the parent's piece takes no part, the parent is not split, nor reached unless it is
// of the base; so the finest ancestor whose piece takes part says where the vertex is shown. Of
// pieces that contradict each other it makes some map all the same.
//
// Goes from one cut to the next: a piece is gone through again only where a piece that its vertices
// ask has come, gone, or shows other vertices than before. Pieces that were not there need not be
// remembered: where one comes and shows anything, the ancestor that was asked instead is split.
class ShownVertices
{
public:
  // pieces: those of PiecesOf(cut), in this order; kept until the next call. The first time O(v log
  // pieces) for v vertices; then so much of the pieces that are gone through again.
  void GoTo(const Cut& cut, std::vector<const Piece*> pieces);

  const std::vector<const Piece*>& Pieces() const { return this->All; }
  // Whether the i-th piece is new, or some vertex of it is shown by another node than before.
  bool HasChanged(std::size_t i) const { return this->Numbered[i]->changed; }

  // Whether an own vertex or a ghost of the i-th piece is itself in the cut.
  bool IsInCut(std::size_t i, std::uint32_t v) const
  {
    return this->Numbered[i]->shown[v] == this->All[i]->id.resolution;
  }

  // The own vertex of a piece that shows a vertex of the i-th one. Nothing where only
  // what is finer is shown, or where pieces contradict each other.
  using Place = ClusterOwners::Place;
  std::optional<Place> NodeAbove(std::size_t i, std::uint32_t v);

  // The nodes above an own vertex of the i-th piece, as far as the pieces tell of them.
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
    Resolution shown; // where it is not
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
  std::optional<Resolution> LastFinest; // of it
};

}
