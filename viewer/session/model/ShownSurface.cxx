// SPDX-License-Identifier: BSD-3-Clause
// The shown surface: chooses its cut from the loaded pieces, and draws it. Step "draw" of the
// pipeline picture.
#include "viewer/session/model/ShownSurface.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{
namespace
{

bool AnyOf(const std::vector<PieceId>& ids, const std::set<PieceId>& set)
{
  return std::any_of(ids.begin(), ids.end(), [&set](PieceId id) { return set.count(id) != 0; });
}

}

ShownSurface::ShownSurface()
  : Drawn(std::make_shared<DrawnSurface>())
{
}

void ShownSurface::Reset(const TreeDepths& depths)
{
  this->Depths = depths;
  this->Shown.reset();
  this->Used.clear();
  this->Refined.clear();
  this->FinestDrawn.reset();
  this->Dirty = false;
  this->Closing = {};
  this->Parts = {};
  this->Parts.Follow(this->Geomorphs);
  this->Normals = {};
  this->Drawn = std::make_shared<DrawnSurface>();
  ++this->DrawnVersion;
}

// Makes a cut of a base and finer pieces, and lists the pieces for it that are not loaded.
ShownSurface::Choice ShownSurface::MakeChoice(
  Resolution base, const std::vector<PieceId>& wanted, PieceCache& pieces)
{
  const PieceLookup lookup = [&pieces](PieceId id) { return pieces.Find(id); };
  Choice choice{ { this->Depths, base }, {} };
  Closure closure = this->Closing.Make(this->Depths, base, wanted, lookup);
  choice.cut.active = std::move(closure.pieces);
  choice.missing = MissingPieces(choice.cut, lookup);
  std::vector<PieceId> all;
  std::set_union(choice.missing.begin(), choice.missing.end(), closure.missing.begin(),
    closure.missing.end(), std::back_inserter(all));
  choice.missing = std::move(all);
  return choice;
}

ShownSurface::Needs ShownSurface::NeedsOf(const SurfaceWish& wish, PieceCache& pieces)
{
  Needs needs;
  const auto add = [&needs](const Choice& choice)
  {
    const std::vector<PieceId> used = PiecesOf(choice.cut);
    needs.all.insert(used.begin(), used.end());
    needs.all.insert(choice.cut.active.begin(), choice.cut.active.end());
    needs.missing.insert(needs.missing.end(), choice.missing.begin(), choice.missing.end());
  };
  add(this->MakeChoice(wish.base, {}, pieces));
  if (wish.pieces.empty())
  {
    return needs;
  }
  const Resolution base = needs.missing.empty() || !this->Shown ? wish.base : this->Shown->base;
  add(this->MakeChoice(base, wish.pieces, pieces));
  auto& missing = needs.missing;
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  return needs;
}

void ShownSurface::Choose(
  const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed)
{
  std::vector<PieceId> loaded;
  std::copy_if(wish.pieces.begin(), wish.pieces.end(), std::back_inserter(loaded),
    [&pieces](PieceId id) { return pieces.Peek(id) != nullptr; });
  const Choice best = this->MakeChoice(wish.base, loaded, pieces);
  if (this->Show(best) ||
      (this->Shown && this->Show(this->MakeChoice(this->Shown->base, loaded, pieces))))
  {
    return;
  }
  if (!this->Shown || AnyOf(best.missing, failed))
  {
    this->Show(this->MakeChoice(wish.base, {}, pieces));
  }
}

ShownSurface::Needs ShownSurface::ShowWhole(
  const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed)
{
  this->Choose(wish, pieces, failed);
  return this->NeedsOf(wish, pieces);
}

ShownSurface::Needs ShownSurface::ShowLoaded(const SurfaceWish& wish, PieceCache& pieces)
{
  Choice choice = this->MakeChoice(wish.base, wish.pieces, pieces);
  const std::vector<PieceId> used = PiecesOf(choice.cut);
  Needs needs{ { used.begin(), used.end() }, choice.missing };
  needs.all.insert(choice.cut.active.begin(), choice.cut.active.end());
  const PieceLookup peek = [&pieces](PieceId id) { return pieces.Peek(id); };
  std::erase_if(choice.cut.active, [&peek](PieceId id) { return !peek(id); });
  choice.missing = MissingPieces(choice.cut, peek);
  this->Show(choice);
  return needs;
}

// Shows a cut if all its pieces are loaded.
bool ShownSurface::Show(const Choice& choice)
{
  if (!choice.missing.empty())
  {
    return false;
  }
  const Cut& cut = choice.cut;
  if (!this->Shown || this->Shown->base != cut.base || this->Shown->active != cut.active)
  {
    this->Shown = cut;
    this->Dirty = true;
  }
  const std::vector<PieceId> used = PiecesOf(cut);
  this->Used = { used.begin(), used.end() };
  return true;
}

Result<bool> ShownSurface::Draw(PieceCache& pieces)
{
  if (!this->Dirty)
  {
    return false;
  }
  this->Dirty = false;
  KDSTREAM_TRY(this->Parts.GoTo(*this->Shown, [&pieces](PieceId id) { return pieces.Find(id); }));
  this->Normals.GoTo(this->Parts.Parts());
  this->Drawn = std::make_shared<DrawnSurface>(
    this->Parts.Parts(), this->Normals.Of(), *this->Drawn, this->Parts.Parents());
  ++this->DrawnVersion;
  this->NoteWhatIsDrawn(pieces);
  return true;
}

// Finds out which partitions are drawn completely as the original: with all vertices that their
// pieces own.
void ShownSurface::NoteWhatIsDrawn(PieceCache& pieces)
{
  this->FinestDrawn.reset();
  this->Refined.clear();
  for (const DrawnSurface::Part& drawn : this->Drawn->Parts())
  {
    const PieceId id = drawn.part->piece;
    this->FinestDrawn = std::max(this->FinestDrawn.value_or(id.resolution), id.resolution);
    const Piece* piece = id.resolution.IsOriginal() ? pieces.Peek(id) : nullptr;
    if (piece && piece->ownVertices == drawn.part->own.size())
    {
      this->Refined.insert(id.node - (NodeId{ 1 } << this->Depths.partition));
    }
  }
}

}
