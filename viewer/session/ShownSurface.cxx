// SPDX-License-Identifier: BSD-3-Clause
// The surface that is shown: which cut, out of what is loaded, and its drawing. Step "draw" of the
// README's picture.
#include "viewer/session/ShownSurface.h"

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
  : Drawn(std::make_shared<Surface>())
{
}

void ShownSurface::Reset(const TreeDepths& depths)
{
  this->Depths = depths;
  this->Shown.reset();
  ++this->ShownVersion;
  this->Used.clear();
  this->Dirty = false;
  this->Drawn = std::make_shared<Surface>();
  ++this->DrawnVersion;
}

// A level with some partitions as the original, and what of that is not loaded.
ShownSurface::Choice ShownSurface::MakeChoice(
  unsigned level, const std::vector<std::uint32_t>& partitions, PieceCache& pieces) const
{
  const PieceLookup lookup = [&pieces](PieceId id) { return pieces.Find(id); };
  std::vector<PieceId> wanted;
  for (const std::uint32_t partition : partitions)
  {
    wanted.push_back({ Resolution::Original(), NodeOfPartition(partition, this->Depths) });
  }
  Choice choice{ { this->Depths, Resolution::Level(level) }, {} };
  Closure closure = MakeClosure(this->Depths, choice.cut.base, wanted, lookup);
  choice.cut.active = std::move(closure.pieces);
  choice.missing = MissingPieces(choice.cut, lookup);
  std::vector<PieceId> all;
  std::set_union(choice.missing.begin(), choice.missing.end(), closure.missing.begin(),
    closure.missing.end(), std::back_inserter(all));
  choice.missing = std::move(all);
  return choice;
}

ShownSurface::Needs ShownSurface::NeedsOf(const SurfaceWish& wish, PieceCache& pieces) const
{
  Needs needs;
  const auto add = [&needs](const Choice& choice)
  {
    const std::vector<PieceId> used = PiecesOf(choice.cut);
    needs.all.insert(used.begin(), used.end());
    needs.all.insert(choice.cut.active.begin(), choice.cut.active.end());
    needs.missing.insert(needs.missing.end(), choice.missing.begin(), choice.missing.end());
  };
  add(this->MakeChoice(wish.level, {}, pieces));
  if (wish.region.empty())
  {
    return needs;
  }
  const unsigned level =
    needs.missing.empty() || !this->Shown ? wish.level : this->Shown->base.Depth();
  add(this->MakeChoice(level, wish.region, pieces));
  auto& missing = needs.missing;
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  return needs;
}

void ShownSurface::Choose(
  const SurfaceWish& wish, PieceCache& pieces, const std::set<PieceId>& failed)
{
  std::vector<std::uint32_t> loaded;
  for (const std::uint32_t partition : wish.region)
  {
    if (pieces.Peek({ Resolution::Original(), NodeOfPartition(partition, this->Depths) }))
    {
      loaded.push_back(partition);
    }
  }
  const Choice best = this->MakeChoice(wish.level, loaded, pieces);
  if (this->Show(best) ||
      (this->Shown && this->Show(this->MakeChoice(this->Shown->base.Depth(), loaded, pieces))))
  {
    return;
  }
  if (!this->Shown || AnyOf(best.missing, failed))
  {
    this->Show(this->MakeChoice(wish.level, {}, pieces));
  }
}

// Shows a cut if all its pieces are there.
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
    ++this->ShownVersion;
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
  auto surface = DrawSurface(*this->Shown, [&pieces](PieceId id) { return pieces.Find(id); });
  KDSTREAM_TRY(surface);
  this->Drawn = std::make_shared<Surface>(std::move(*surface));
  ++this->DrawnVersion;
  return true;
}

}
