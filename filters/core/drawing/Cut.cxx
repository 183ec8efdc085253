// SPDX-License-Identifier: BSD-3-Clause
// Which pieces a cut draws, and which it needs in addition: see Cut.h.
#include "filters/core/drawing/Cut.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

std::size_t PieceCountOf(Resolution resolution, const TreeDepths& depths)
{
  return std::size_t{ 1 } << PieceDepth(resolution, depths);
}

bool IsOfTree(PieceId id, const TreeDepths& depths)
{
  return (id.resolution.IsOriginal() || id.resolution.Depth() <= depths.finest) && id.node > 0 &&
         DepthOfNode(id.node) == PieceDepth(id.resolution, depths);
}

// The piece of a coarser resolution that holds a piece's node.
PieceId PieceAbove(Resolution resolution, PieceId id, const TreeDepths& depths)
{
  return { resolution,
    id.node >> (PieceDepth(id.resolution, depths) - PieceDepth(resolution, depths)) };
}

// Decides which pieces of level S and finer show anything.
class FinePieces
{
public:
  FinePieces(const Cut& cut, Resolution base)
    : C(cut)
    , Base(base)
    , Stitch(Resolution::Level(cut.depths.stitch))
  {
  }

  bool Shows(PieceId id) const
  {
    const TreeDepths& depths = this->C.depths;
    if (this->Base < this->Stitch)
    {
      // Finer vertices are reached only through their cluster of level S.
      return id.resolution == this->Stitch ||
             std::binary_search(
               this->C.active.begin(), this->C.active.end(), PieceAbove(this->Stitch, id, depths));
    }
    const auto finer = std::upper_bound(this->C.active.begin(), this->C.active.end(),
      PieceId{ id.resolution, std::numeric_limits<NodeId>::max() });
    if (finer == this->C.active.end())
    {
      return true;
    }
    const unsigned below = depths.partition - DepthOfNode(id.node);
    const NodeId first = id.node << below;
    for (NodeId node = first; node < first + (NodeId{ 1 } << below); ++node)
    {
      if (!this->IsCovered(finer->resolution, node))
      {
        return true;
      }
    }
    return false;
  }

private:
  // Whether a resolution from `from` on is active in a partition.
  bool IsCovered(Resolution from, NodeId node) const
  {
    const TreeDepths& depths = this->C.depths;
    auto next = std::lower_bound(this->C.active.begin(), this->C.active.end(), PieceId{ from, 0 });
    while (next != this->C.active.end())
    {
      const Resolution resolution = next->resolution;
      const PieceId holder = PieceAbove(resolution, { Resolution::Original(), node }, depths);
      if (std::binary_search(next, this->C.active.end(), holder))
      {
        return true;
      }
      next = std::upper_bound(
        next, this->C.active.end(), PieceId{ resolution, std::numeric_limits<NodeId>::max() });
    }
    return false;
  }

  const Cut& C;
  Resolution Base, Stitch;
};

// Finds the closure of some pieces, level by level from the base down.
class Closing
{
public:
  Closing(const TreeDepths& depths, Resolution base, const PieceLookup& lookup)
    : Depths(depths)
    , Base(base)
    , Stitch(Resolution::Level(depths.stitch))
    , Lookup(lookup)
  {
  }

  // known: pieces that are needed in any case, and need no pieces except each other.
  Closure Close(std::span<const PieceId> wanted, std::span<const PieceId> known)
  {
    std::copy_if(wanted.begin(), wanted.end(), std::inserter(this->Needed, this->Needed.end()),
      [this](PieceId id) { return id.resolution > this->Base; });
    this->WantRoot();
    const std::vector<PieceId> finer(this->Needed.begin(), this->Needed.end());
    this->Needed.insert(known.begin(), known.end());
    if (this->Base < this->Stitch && !finer.empty())
    {
      this->NameAbove(finer);
      const auto rows = this->RowsOf(finer);
      for (unsigned d = this->Base.Depth(); d < this->Depths.stitch; ++d)
      {
        this->FollowChildren(d, rows);
      }
    }
    Closure closure{ { this->Needed.begin(), this->Needed.end() }, {} };
    std::copy_if(closure.pieces.begin(), closure.pieces.end(), std::back_inserter(closure.missing),
      [this](PieceId id) { return this->Lookup(id) == nullptr; });
    return closure;
  }

private:
  // If the base is coarser than R and S, it cannot be mixed with a finer level: the finer level
  // must become the base as a whole.
  void WantRoot()
  {
    const auto root = Resolution::Level(std::min(PreviewLevel(this->Depths), this->Depths.stitch));
    if (this->Base >= root || this->Needed.empty())
    {
      return;
    }
    const Resolution finest = this->Needed.rbegin()->resolution;
    if (finest > root)
    {
      this->Needed.insert({ root, 1 });
      this->Base = root;
    }
    else
    {
      this->Base = finest; // one piece, and it is wanted
    }
  }

  // Adds the pieces of coarser levels in the nodes above the wanted pieces: most of the needed
  // ancestors are in these.
  void NameAbove(const std::vector<PieceId>& wanted)
  {
    for (const PieceId id : wanted)
    {
      for (unsigned d = this->Base.Depth() + 1;
           d <= this->Depths.stitch && Resolution::Level(d) < id.resolution; ++d)
      {
        this->Needed.insert(PieceAbove(Resolution::Level(d), id, this->Depths));
      }
    }
  }

  // Adds the pieces of level depth + 1 that hold the children of the ancestors, at level `depth`,
  // of the wanted pieces' vertices. rows: from RowsOf.
  void FollowChildren(unsigned depth, const std::vector<std::span<const std::uint32_t>>& rows)
  {
    const std::size_t place = depth - PreviewLevel(this->Depths);
    std::vector<std::uint32_t> above;
    for (const auto& row : rows)
    {
      if (place < row.size())
      {
        above.push_back(row[place]);
      }
    }
    std::sort(above.begin(), above.end());
    above.erase(std::unique(above.begin(), above.end()), above.end());
    std::vector<const Piece*> pieces;
    ClusterOwners owners;
    const auto add = [&](PieceId id)
    {
      const Piece* piece = this->Lookup(id);
      if (piece)
      {
        owners.Add(*piece, pieces.size());
        pieces.push_back(piece);
      }
    };
    const Resolution level = Resolution::Level(depth);
    if (level == this->Base)
    {
      for (std::size_t i = 0; i < PieceCountOf(level, this->Depths); ++i)
      {
        add({ level, static_cast<NodeId>(PieceCountOf(level, this->Depths) + i) });
      }
    }
    else
    {
      std::for_each(this->Needed.lower_bound({ level, 0 }),
        this->Needed.upper_bound({ level, std::numeric_limits<NodeId>::max() }), add);
    }
    for (const std::uint32_t rank : above)
    {
      if (const auto owner = owners.Find(depth, rank))
      {
        const Piece& piece = *pieces[owner->piece];
        for (std::uint32_t i = piece.childBegin[owner->vertex];
             i < piece.childBegin[owner->vertex + 1]; ++i)
        {
          this->Needed.insert({ Resolution::Level(depth + 1), piece.childNodes[i] });
        }
      }
    }
  }

  // The ancestors of the own vertices of loaded wanted pieces; for pieces finer than S, the
  // ancestors of the clusters of level S.
  std::vector<std::span<const std::uint32_t>> RowsOf(const std::vector<PieceId>& wanted) const
  {
    std::vector<std::span<const std::uint32_t>> rows;
    for (const PieceId id : wanted)
    {
      const bool fine = id.resolution > this->Stitch;
      const Piece* piece = this->Lookup(fine ? PieceAbove(this->Stitch, id, this->Depths) : id);
      if (!piece)
      {
        continue;
      }
      const unsigned depth = PieceDepth(id.resolution, this->Depths);
      const auto begin = piece->keys.begin(), end = begin + std::ptrdiff_t(piece->ownVertices);
      const auto first =
        fine ? std::lower_bound(begin, end, this->FirstKey(id.node, depth)) : begin;
      const auto last =
        fine ? std::lower_bound(first, end, this->FirstKey(id.node + 1, depth)) : end;
      for (auto key = first; key != last; ++key)
      {
        rows.push_back(piece->AncestorsOf(static_cast<std::uint32_t>(key - begin), this->Depths));
      }
    }
    return rows;
  }

  // The lowest key that a vertex in a node can have at resolutions >= S. For the node after the
  // last one of its depth: a key above all others.
  VertexKey FirstKey(NodeId node, unsigned depth) const
  {
    return VertexKey{ node - (NodeId{ 1 } << depth) } << (this->Depths.partition - depth + 32);
  }

  const TreeDepths& Depths;
  Resolution Base;
  const Resolution Stitch;
  const PieceLookup& Lookup;
  std::set<PieceId> Needed;
};

}

Status CheckCut(const Cut& cut)
{
  if (!cut.base.IsOriginal() && cut.base.Depth() > cut.depths.finest)
  {
    return Error{ ErrorCode::InvalidArgument, "level " + std::to_string(cut.base.Depth()) +
                                                " is finer than the finest, " +
                                                std::to_string(cut.depths.finest) };
  }
  for (std::size_t i = 0; i < cut.active.size(); ++i)
  {
    const PieceId id = cut.active[i];
    if (!IsOfTree(id, cut.depths))
    {
      return Error{ ErrorCode::InvalidArgument,
        "node " + std::to_string(id.node) + " is not a piece of " +
          (id.resolution.IsOriginal() ? "the original"
                                      : "level " + std::to_string(id.resolution.Depth())) };
    }
    if (i > 0 && id <= cut.active[i - 1])
    {
      return Error{ ErrorCode::InvalidArgument,
        "active pieces are not in ascending order at " + std::to_string(i) + "" };
    }
  }
  return {};
}

Resolution BaseOf(const Cut& cut)
{
  Resolution base = cut.base;
  for (auto begin = cut.active.begin(); begin != cut.active.end();)
  {
    const Resolution resolution = begin->resolution;
    const auto end = std::find_if(
      begin, cut.active.end(), [resolution](PieceId id) { return id.resolution != resolution; });
    if (resolution > base &&
        static_cast<std::size_t>(end - begin) == PieceCountOf(resolution, cut.depths))
    {
      base = resolution;
    }
    begin = end;
  }
  return base;
}

std::vector<PieceId> PiecesOf(const Cut& cut)
{
  const TreeDepths& depths = cut.depths;
  const Resolution base = BaseOf(cut), stitch = Resolution::Level(depths.stitch);
  const FinePieces fine(cut, base);
  std::vector<PieceId> pieces;
  const auto add = [&](PieceId id)
  {
    if (id.resolution < stitch || fine.Shows(id))
    {
      pieces.push_back(id);
    }
  };
  for (std::size_t i = 0; i < PieceCountOf(base, depths); ++i)
  {
    add({ base, static_cast<NodeId>(PieceCountOf(base, depths) + i) });
  }
  if (base >= std::min(stitch, Resolution::Level(PreviewLevel(depths))))
  {
    std::for_each(std::upper_bound(cut.active.begin(), cut.active.end(),
                    PieceId{ base, std::numeric_limits<NodeId>::max() }),
      cut.active.end(), add);
  }
  return pieces;
}

std::vector<PieceId> MissingPieces(const Cut& cut, const PieceLookup& lookup)
{
  std::vector<PieceId> pieces = PiecesOf(cut);
  std::erase_if(pieces, [&](PieceId id) { return lookup(id) != nullptr; });
  return pieces;
}

Closure MakeClosure(const TreeDepths& depths, Resolution base, std::span<const PieceId> wanted,
  const PieceLookup& lookup)
{
  return Closing(depths, base, lookup).Close(wanted, {});
}

Closure Closures::Make(const TreeDepths& depths, Resolution base, std::span<const PieceId> wanted,
  const PieceLookup& lookup)
{
  auto before = std::exchange(this->Whole, {});
  if (depths != this->Depths || base != this->Base)
  {
    before.clear();
  }
  this->Depths = depths;
  this->Base = base;
  std::vector<PieceId> known, others;
  for (const PieceId id : wanted)
  {
    auto whole = before.extract(id);
    if (whole.empty())
    {
      others.push_back(id);
      continue;
    }
    known.insert(known.end(), whole.mapped().begin(), whole.mapped().end());
    this->Whole.insert(std::move(whole));
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  for (const PieceId id : others)
  {
    if (lookup(id))
    {
      Closure alone = Closing(depths, base, lookup).Close({ &id, 1 }, {});
      if (alone.missing.empty())
      {
        this->Whole[id] = std::move(alone.pieces);
      }
    }
  }
  return Closing(depths, base, lookup).Close(others, known);
}

std::uint32_t IntervalOf(const Piece& piece, VertexKey key)
{
  const VertexKey *const begin = piece.keys.data(), *const end = begin + piece.ownVertices;
  const auto above = std::upper_bound(begin, end, key);
  if (above == begin || PartitionOfKey(*(above - 1)) != PartitionOfKey(key))
  {
    return noVertex;
  }
  return static_cast<std::uint32_t>(above - begin) - 1;
}

void ClusterOwners::Add(const Piece& piece, std::size_t number)
{
  const std::size_t level = piece.id.resolution.Depth();
  if (this->Levels.size() <= level)
  {
    this->Levels.resize(level + 1);
    this->Last.resize(level + 1);
  }
  if (piece.ownVertices > 0)
  {
    this->Levels[level][piece.keys[0]] = { piece.keys[0], piece.ownVertices, number };
  }
}

std::optional<ClusterOwners::Place> ClusterOwners::Find(unsigned level, VertexKey rank)
{
  if (level >= this->Levels.size())
  {
    return {};
  }
  Owner& owner = this->Last[level];
  if (rank - owner.first >= owner.count) // if rank < first, the difference is huge
  {
    const auto above = this->Levels[level].upper_bound(rank);
    if (above == this->Levels[level].begin())
    {
      return {};
    }
    const Owner& found = std::prev(above)->second;
    if (rank - found.first >= found.count)
    {
      return {};
    }
    owner = found;
  }
  return Place{ owner.number, static_cast<std::uint32_t>(rank - owner.first) };
}

}
