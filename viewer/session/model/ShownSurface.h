// SPDX-License-Identifier: BSD-3-Clause
// The shown surface: chooses its cut from the loaded pieces, and draws it. Step "draw" of the
// pipeline picture.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"
#include "viewer/session/model/PieceCache.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace kdstream
{

// The surface that is wanted.
struct SurfaceWish
{
  Resolution base;             // everywhere
  std::vector<PieceId> pieces; // in addition, finer than the base, in any order
  bool operator==(const SurfaceWish&) const = default;
};

// Holds the shown cut of one model. All pieces of the shown cut are always loaded, so that one
// whole surface is drawn at every moment: a finer base replaces the old one only when all of it has
// arrived.
class ShownSurface
{
public:
  ShownSurface();
  // Forgets what is shown: the surface is empty.
  void Reset(const TreeDepths& depths);

  // The pieces that a whole wish needs, and the missing ones, ascending. Which pieces are needed
  // between a level and a region in it is known only from other pieces: so ask again after each
  // that arrives.
  struct Needs
  {
    std::set<PieceId> all; // to keep
    std::vector<PieceId> missing;
  };

  // Shows the best cut that the loaded pieces allow. The first of these that is whole:
  // 1. the wished base with the loaded pieces;
  // 2. the shown base with the loaded pieces;
  // 3. if `failed` has a piece that 1 needs: only the wished base;
  // 4. what is shown already.
  //
  // If nothing is shown yet: the wished base, or nothing. The wished pieces are shown over the
  // wished base when it is loaded, until then over the shown one.
  Needs ShowWhole(const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed);

  // When the base is loaded, shows all loaded pieces of those that the wish needs: any set of
  // pieces is a cut.
  Needs ShowLoaded(const SurfaceWish& wish, PieceCache& pieces);

  bool IsEmpty() const { return !this->Shown.has_value(); }
  const std::optional<Cut>& GetCut() const { return this->Shown; }
  // Whether all of the partition is drawn as the original. O(log partitions).
  bool IsRefined(std::uint32_t partition) const { return this->Refined.count(partition) != 0; }
  // The finest resolution in what is drawn.
  std::optional<Resolution> Finest() const { return this->FinestDrawn; }
  // The pieces that the shown cut needs.
  const std::set<PieceId>& Pieces() const { return this->Used; }

  // Draws what has changed in the shown cut; true if the surface is another one now. Errors: those
  // of SurfaceParts, if pieces were evicted: pin Pieces().
  Result<bool> Draw(PieceCache& pieces);
  bool NeedsDrawing() const { return this->Dirty; }
  // Whether the parts of each later surface morph from the surface before it.
  void SetGeomorphs(bool geomorphs)
  {
    this->Geomorphs = geomorphs;
    this->Parts.Follow(geomorphs);
  }
  // As SurfaceParts::KeepCorners.
  void KeepCorners(bool ofOriginal, bool ofLevels)
  {
    this->Parts.KeepCorners(ofOriginal, ofLevels);
  }
  const std::shared_ptr<const DrawnSurface>& GetSurface() const { return this->Drawn; }
  std::uint64_t Version() const { return this->DrawnVersion; }

private:
  struct Choice
  {
    Cut cut;
    std::vector<PieceId> missing; // ascending
  };
  Choice MakeChoice(Resolution base, const std::vector<PieceId>& wanted, PieceCache& pieces);
  Needs NeedsOf(const SurfaceWish& wish, PieceCache& pieces);
  void Choose(const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed);
  bool Show(const Choice& choice);
  void NoteWhatIsDrawn(PieceCache& pieces);

  TreeDepths Depths;
  std::optional<Cut> Shown;
  std::set<PieceId> Used;
  bool Dirty = false;
  bool Geomorphs = false;
  Closures Closing;
  SurfaceParts Parts;
  PartNormals Normals;
  std::shared_ptr<const DrawnSurface> Drawn;
  std::uint64_t DrawnVersion = 0;
  std::set<std::uint32_t> Refined; // partitions
  std::optional<Resolution> FinestDrawn;
};

}
