// SPDX-License-Identifier: BSD-3-Clause
// Which vertices of a cut's pieces are shown, and by what the others are: for Surface.cxx alone.
#pragma once

#include "filters/core/drawing/Cut.h"

#include <cstddef>
#include <cstdint>
#include <map>
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
class ShownVertices
{
public:
  // pieces: those of PiecesOf(cut), in this order; kept. O(v log pieces).
  ShownVertices(const Cut& cut, std::vector<const Piece*> pieces);

  const std::vector<const Piece*>& Pieces() const { return this->All; }

  // The resolution at which a vertex of the i-th piece is shown, at most the piece's; nothing where
  // only what is finer is shown.
  std::optional<Resolution> ShownAt(std::size_t i, std::uint32_t v) const
  {
    const Resolution shown = this->Shown[i][v];
    return shown == above ? std::nullopt : std::optional(shown);
  }

  // The own vertex of a piece that shows a vertex of the i-th one. Nothing where ShownAt says
  // nothing, or where pieces contradict each other.
  using Place = ClusterOwners::Place;
  std::optional<Place> NodeAbove(std::size_t i, std::uint32_t v);

private:
  // In lists of resolutions, for vertices above the cut: finer than every level.
  static constexpr Resolution above = Resolution::Level(Resolution::maximumLevel);

  struct Ancestry
  {
    bool parentIsSplit = false;
    Resolution shown; // where it is not
  };
  Ancestry Ask(const Piece& piece, std::uint32_t v);
  Resolution ShownOwn(const Piece& piece, std::uint32_t v);
  Resolution ShownGhost(const Piece& piece, std::uint32_t v);
  Resolution InPartition(const Piece& piece, std::uint32_t v);
  Resolution FinestOf(std::uint32_t partition) const;
  bool IsSplit(const Piece& piece, std::uint32_t v) const;
  bool IsActive(PieceId id) const;
  std::optional<Place> IntervalAt(Resolution resolution, VertexKey key) const;
  std::optional<Place> StitchClusterOf(VertexKey key) const;

  const Cut& C;
  const Resolution Base, Stitch;
  std::vector<const Piece*> All;
  std::vector<std::vector<Resolution>> Shown; // of each piece's vertices
  std::map<PieceId, std::size_t> Numbers;     // of pieces
  ClusterOwners Owners;
  std::uint32_t LastPartition = 0;
  std::optional<Resolution> LastFinest; // of it
};

}
