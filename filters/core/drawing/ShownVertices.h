// SPDX-License-Identifier: BSD-3-Clause
// Decides which vertices of a cut's pieces are shown, and by which vertices the others are
// represented. Only for SurfaceParts.cxx.
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
// reached. If the parent's piece is not in the cut, the parent is not split, and it is reached only
// if it is of the base; then the finest ancestor whose piece is in the cut decides. If pieces
// contradict each other, the result is still some map.
//
// Works incrementally from one cut to the next. A piece is processed again only if a piece that its
// vertices depend on was added or removed, or shows other vertices than before. Missing pieces need
// not be remembered: if one is added and shows anything, the ancestor that was used instead becomes
// split.
class ShownVertices
{
public:
  // pieces: those of PiecesOf(cut), in this order; they must stay valid until the next call. The
  // first call takes O(v log pieces) for v vertices; a later call takes the same for the vertices
  // of pieces that are processed again.
  void GoTo(const Cut& cut, std::vector<const Piece*> pieces);

  const std::vector<const Piece*>& Pieces() const { return this->All; }
  // Whether the i-th piece is new, or some vertex of it is shown by another node than before.
  bool HasChanged(std::size_t i) const { return this->Numbered[i]->changed; }

  // Whether vertex `v` of the i-th piece, own or ghost, is itself in the cut.
  bool IsInCut(std::size_t i, std::uint32_t v) const
  {
    return this->Numbered[i]->shown[v] == this->All[i]->id.resolution;
  }

  // The own vertex of a piece that shows a vertex of piece `i`. No value if only finer vertices are
  // shown there, or if pieces contradict each other.
  using Place = ClusterOwners::Place;
  std::optional<Place> NodeAbove(std::size_t i, std::uint32_t v);

  // The nodes above an own vertex of piece `i`, as far as the pieces know them.
  Lineage LineageOf(std::size_t i, std::uint32_t v);

private:
  // Stands for vertices above the cut in lists of resolutions; finer than every level.
  static constexpr Resolution above = Resolution::Level(Resolution::maximumLevel);

  using Keys = std::vector<std::uint64_t>; // of pieces: KeyOf

  struct Known // of one piece
  {
    std::vector<Resolution> shown; // of its vertices
    // The pieces that were consulted for own vertices, and for ghosts: ascending, each once.
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
  // The pieces and partitions consulted so far for the piece that is being processed.
  Keys AskedPieces, AskedPartitions;
  std::optional<Place> LastInterval; // the last one found: keys mostly come in order
  std::uint32_t LastPartition = 0;
  std::optional<Resolution> LastFinest; // the finest resolution of LastPartition
};

}
