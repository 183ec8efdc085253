// SPDX-License-Identifier: BSD-3-Clause
// The surface that is shown: which cut, out of what is loaded, and its drawing. Step "draw" of the
// README's picture.
#include "viewer/session/ShownSurface.h"

#include <algorithm>

namespace kdstream
{
namespace
{

PieceLookup LookupIn(PieceCache& pieces)
{
  return [&pieces](PieceId id) { return pieces.Find(id); };
}

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

Cut ShownSurface::MakeCut(unsigned level, const std::vector<std::uint32_t>& partitions) const
{
  Cut cut{ this->Depths, Resolution::Level(level), {} };
  if (!partitions.empty())
  {
    cut.refined.resize(std::size_t{ 1 } << this->Depths.partition);
  }
  for (const std::uint32_t partition : partitions)
  {
    cut.refined[partition] = Resolution::Original();
  }
  return cut;
}

ShownSurface::Needs ShownSurface::NeedsOf(const SurfaceWish& wish, PieceCache& pieces) const
{
  Needs needs;
  const PieceLookup noting = [&pieces, &needs](PieceId id)
  {
    needs.all.insert(id);
    return pieces.Find(id);
  };
  needs.missing = MissingPieces(this->MakeCut(wish.level, {}), noting);
  if (wish.region.empty())
  {
    return needs;
  }
  const unsigned level =
    needs.missing.empty() || !this->Shown ? wish.level : this->Shown->base.Depth();
  for (const PieceId id : MissingPieces(this->MakeCut(level, wish.region), noting))
  {
    needs.all.insert(id);
    needs.missing.push_back(id);
  }
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
  const Cut best = this->MakeCut(wish.level, loaded);
  if (this->Show(best, pieces) ||
      (this->Shown && this->Show(this->MakeCut(this->Shown->base.Depth(), loaded), pieces)))
  {
    return;
  }
  if (!this->Shown || AnyOf(MissingPieces(best, LookupIn(pieces)), failed))
  {
    this->Show(this->MakeCut(wish.level, {}), pieces);
  }
}

// Shows a cut if all its pieces are there.
bool ShownSurface::Show(const Cut& cut, PieceCache& pieces)
{
  std::set<PieceId> used;
  const PieceLookup noting = [&pieces, &used](PieceId id)
  {
    used.insert(id);
    return pieces.Find(id);
  };
  if (!MissingPieces(cut, noting).empty())
  {
    return false;
  }
  if (!this->Shown || this->Shown->base != cut.base || this->Shown->refined != cut.refined)
  {
    this->Shown = cut;
    ++this->ShownVersion;
    this->Dirty = true;
  }
  this->Used = std::move(used);
  return true;
}

Result<bool> ShownSurface::Draw(PieceCache& pieces)
{
  if (!this->Dirty)
  {
    return false;
  }
  this->Dirty = false;
  auto surface = DrawSurface(*this->Shown, LookupIn(pieces));
  KDSTREAM_TRY(surface);
  this->Drawn = std::make_shared<Surface>(std::move(*surface));
  ++this->DrawnVersion;
  return true;
}

}
