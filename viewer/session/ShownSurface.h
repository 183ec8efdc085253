// SPDX-License-Identifier: BSD-3-Clause
// The surface that is shown: which cut, out of what is loaded, and its drawing. Step "draw" of the
// README's picture.
#pragma once

#include "filters/core/drawing/Surface.h"
#include "viewer/session/PieceCache.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace kdstream
{

// What one would like to see.
struct SurfaceWish
{
  unsigned level = 0;                // everywhere
  std::vector<std::uint32_t> region; // these partitions as the original, nearest first
  bool operator==(const SurfaceWish&) const = default;
};

// Holds the shown cut of one model. All pieces of the shown cut are always loaded, so that one
// whole surface is drawn at every moment: a finer level replaces the old one only when all of it
// has come.
class ShownSurface
{
public:
  ShownSurface();
  // Forgets what is shown: the surface is empty.
  void Reset(const TreeDepths& depths);

  // What the whole wish needs, and what of it is missing, ascending. Which pieces between a level
  // and a region in it are needed is known only from other pieces: ask again after each that
  // arrives.
  // The region is taken in the wished level once that is loaded, until then in the shown one.
  struct Needs
  {
    std::set<PieceId> all; // to keep
    std::vector<PieceId> missing;
  };
  Needs NeedsOf(const SurfaceWish& wish, PieceCache& pieces) const;

  // Shows the best cut that the loaded pieces allow, the first that is whole of
  //   the wished level with those partitions of the region that are loaded,
  //   the shown level with these,
  //   where `failed` holds a piece that the first would need: the wished level alone;
  //   what is shown already.
  // Before anything is shown: the wished level, or nothing.
  void Choose(const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed);

  bool IsEmpty() const { return !this->Shown.has_value(); }
  const std::optional<Cut>& GetCut() const { return this->Shown; }
  // Grows whenever another cut is shown.
  std::uint64_t CutVersion() const { return this->ShownVersion; }
  // Whether the partition is shown as the original.
  bool IsRefined(std::uint32_t partition) const
  {
    return this->Shown &&
           std::binary_search(this->Shown->active.begin(), this->Shown->active.end(),
             PieceId{ Resolution::Original(), NodeOfPartition(partition, this->Depths) });
  }
  // The pieces that the shown cut needs.
  const std::set<PieceId>& Pieces() const { return this->Used; }

  // Draws the shown cut if it has changed since; true if there is another surface.
  // Errors: those of DrawSurface, where pieces were evicted: pin Pieces().
  Result<bool> Draw(PieceCache& pieces);
  bool NeedsDrawing() const { return this->Dirty; }
  const std::shared_ptr<const Surface>& GetSurface() const { return this->Drawn; }
  std::uint64_t Version() const { return this->DrawnVersion; }

private:
  struct Choice
  {
    Cut cut;
    std::vector<PieceId> missing; // ascending
  };
  Choice MakeChoice(
    unsigned level, const std::vector<std::uint32_t>& partitions, PieceCache& pieces) const;
  bool Show(const Choice& choice);

  TreeDepths Depths;
  std::optional<Cut> Shown;
  std::uint64_t ShownVersion = 0;
  std::set<PieceId> Used;
  bool Dirty = false;
  std::shared_ptr<const Surface> Drawn;
  std::uint64_t DrawnVersion = 0;
};

}
