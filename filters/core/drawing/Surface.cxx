// SPDX-License-Identifier: BSD-3-Clause
// The drawing rule: see Surface.h.
//   1. The split clusters: base clusters (coarser than S) with an original in a refined partition.
//   2. The pieces that take part, and the points they show: own vertices that are in the cut.
//   3. Each triangle of these pieces: drawn if a vertex is in the cut and none above it; the others
//   move up.
#include "filters/core/drawing/Surface.h"

#include "filters/core/SortTriangles.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace kdstream
{
namespace
{

// What a cut asks of pieces and vertices, once the split is known.
class CutView
{
public:
  CutView(const Cut& cut, const PieceLookup& lookup)
    : C(cut)
    , Lookup(lookup)
    , Mixed(cut.base < this->Stitch() && std::any_of(cut.refined.begin(), cut.refined.end(),
                                           [](const auto& r) { return r.has_value(); }))
  {
  }

  Resolution Stitch() const { return Resolution::Level(this->C.depths.stitch); }

  // The pieces that take part, ascending; those that `lookup` does not find are added to `missing`.
  std::vector<const Piece*> Gather(std::vector<PieceId>& missing)
  {
    std::set<PieceId> wanted;
    this->AddBase(wanted);
    this->AddRefined(wanted);
    if (this->Mixed)
    {
      this->AddSplit(wanted, missing);
    }
    std::vector<const Piece*> pieces;
    for (const PieceId id : wanted)
    {
      const Piece* piece = this->Lookup(id);
      if (piece)
      {
        pieces.push_back(piece);
      }
      else
      {
        missing.push_back(id);
      }
    }
    std::sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    return pieces;
  }

  // The resolution at which the cut shows what lies under vertex `v` of `piece`.
  Resolution ShownAt(const Piece& piece, std::uint32_t v) const
  {
    if (piece.id.resolution < this->Stitch())
    {
      // A cluster below S is the base, or it is split.
      return this->IsSplit(piece.keys[v]) ? this->Stitch() : this->C.base;
    }
    const std::uint32_t partition = PartitionOfKey(piece.keys[v]);
    if (const auto refined = this->C.RefinedTo(partition))
    {
      return *refined;
    }
    if (!this->Mixed)
    {
      return this->C.base;
    }
    return this->IsSplit(this->BaseRank(piece, v)) ? this->Stitch() : this->C.base;
  }

  // The rank of the base cluster above a vertex of a piece >= S. REQUIRES: base coarser than S.
  VertexKey BaseRank(const Piece& piece, std::uint32_t v) const
  {
    auto ancestors = piece.AncestorsOf(v, this->C.depths);
    if (!ancestors.empty())
    {
      return ancestors[this->C.base.Depth()];
    }
    // Own vertices of pieces finer than S: their S cluster knows.
    const Piece* stitch =
      this->Lookup(PieceOfPartition(this->Stitch(), PartitionOfKey(piece.keys[v]), this->C.depths));
    const std::uint32_t cluster = stitch ? IntervalOf(*stitch, piece.keys[v]) : noVertex;
    return cluster == noVertex ? noVertex
                               : stitch->AncestorsOf(cluster, this->C.depths)[this->C.base.Depth()];
  }

  // The own vertex of a level >= S whose interval holds `key`, or noVertex.
  static std::uint32_t IntervalOf(const Piece& piece, VertexKey key)
  {
    const VertexKey *const begin = piece.keys.data(), *const end = begin + piece.ownVertices;
    const auto above = std::upper_bound(begin, end, key);
    if (above == begin || PartitionOfKey(*(above - 1)) != PartitionOfKey(key))
    {
      return noVertex;
    }
    return static_cast<std::uint32_t>(above - begin) - 1;
  }

private:
  bool IsSplit(VertexKey rank) const
  {
    return std::binary_search(this->Split.begin(), this->Split.end(), rank);
  }

  void AddBase(std::set<PieceId>& wanted) const
  {
    const unsigned depth = PieceDepth(this->C.base, this->C.depths);
    const unsigned below = this->C.depths.partition - depth;
    for (NodeId i = 0; i < NodeId{ 1 } << depth; ++i)
    {
      // A piece whose partitions are all refined shows nothing of the base, unless the base is
      // below S, where a cluster may belong to other partitions too.
      bool shown = this->C.refined.empty() || this->C.base < this->Stitch();
      for (std::uint32_t p = i << below; !shown && p < (i + 1) << below; ++p)
      {
        shown = !this->C.refined[p];
      }
      if (shown)
      {
        wanted.insert({ this->C.base, (NodeId{ 1 } << depth) + i });
      }
    }
  }

  void AddRefined(std::set<PieceId>& wanted) const
  {
    for (std::uint32_t p = 0; p < this->C.refined.size(); ++p)
    {
      if (const auto refined = this->C.refined[p])
      {
        wanted.insert(PieceOfPartition(*refined, p, this->C.depths));
      }
    }
  }

  // Finds the split clusters from the level-S pieces of the refined partitions, then asks for all
  // level-S pieces that hold descendants of these.
  void AddSplit(std::set<PieceId>& wanted, std::vector<PieceId>& missing)
  {
    std::set<PieceId> seeds;
    for (std::uint32_t p = 0; p < this->C.refined.size(); ++p)
    {
      if (this->C.refined[p])
      {
        seeds.insert(PieceOfPartition(this->Stitch(), p, this->C.depths));
      }
    }
    for (const PieceId id : seeds)
    {
      const Piece* piece = this->Lookup(id);
      if (!piece)
      {
        missing.push_back(id);
        continue;
      }
      for (std::uint32_t v = 0; v < piece->ownVertices; ++v)
      {
        if (this->C.refined[PartitionOfKey(piece->keys[v])])
        {
          this->Split.push_back(piece->AncestorsOf(v, this->C.depths)[this->C.base.Depth()]);
        }
      }
    }
    wanted.insert(seeds.begin(), seeds.end());
    std::sort(this->Split.begin(), this->Split.end());
    this->Split.erase(std::unique(this->Split.begin(), this->Split.end()), this->Split.end());

    const std::set<PieceId> bases(wanted.lower_bound({ this->C.base, 0 }),
      wanted.upper_bound({ this->C.base, std::numeric_limits<NodeId>::max() }));
    for (const PieceId id : bases)
    {
      const Piece* piece = this->Lookup(id);
      for (std::uint32_t v = 0; piece && v < piece->ownVertices; ++v)
      {
        if (this->IsSplit(piece->keys[v]))
        {
          for (std::uint32_t i = piece->reachBegin[v]; i < piece->reachBegin[v + 1]; ++i)
          {
            wanted.insert({ this->Stitch(), piece->reachNodes[i] });
          }
        }
      }
    }
  }

  const Cut& C;
  const PieceLookup& Lookup;
  bool Mixed; // base coarser than S, and something is refined
  std::vector<VertexKey> Split;
};

// The triangles in ascending order, each once. The lowest index of a triangle comes first, and few
// triangles share it: so they go into a bucket for each lowest index, and two or three are left to
// sort in a bucket. O(triangles + points), unless some points have very many triangles.
std::vector<Triangle> SortedWithoutRepeats(
  const std::vector<Triangle>& triangles, std::size_t points)
{
  std::vector<std::size_t> begin(points + 1, 0);
  for (const Triangle& t : triangles)
  {
    ++begin[t[0] + 1];
  }
  for (std::size_t v = 0; v < points; ++v)
  {
    begin[v + 1] += begin[v];
  }
  std::vector<std::uint64_t> others(triangles.size()); // second and third index
  std::vector<std::size_t> next = begin;
  for (const Triangle& t : triangles)
  {
    others[next[t[0]]++] = std::uint64_t{ t[1] } << 32 | t[2];
  }
  std::vector<Triangle> sorted;
  sorted.reserve(triangles.size());
  for (std::size_t v = 0; v < points; ++v)
  {
    std::uint64_t* const first = others.data() + begin[v];
    std::uint64_t* const last = others.data() + begin[v + 1];
    std::sort(first, last);
    std::for_each(first, std::unique(first, last),
      [&sorted, v](std::uint64_t pair)
      {
        sorted.push_back({ static_cast<VertexId>(v), static_cast<VertexId>(pair >> 32),
          static_cast<VertexId>(pair & 0xFFFFFFFFU) });
      });
  }
  return sorted;
}

class Drawer
{
public:
  Drawer(const Cut& cut, const CutView& view, std::vector<const Piece*> pieces)
    : C(cut)
    , View(view)
    , Pieces(std::move(pieces))
  {
  }

  Surface Draw()
  {
    for (const Piece* piece : this->Pieces)
    {
      this->AddPoints(*piece);
    }
    for (const Piece* piece : this->Pieces)
    {
      this->AddTriangles(*piece);
    }
    this->AddAttributes();
    this->Output.triangles =
      SortedWithoutRepeats(this->Output.triangles, this->Output.points.size());
    return std::move(this->Output);
  }

private:
  struct Shown // the points of one piece that the surface shows
  {
    const Piece* piece = nullptr;
    bool any = false;
    std::vector<VertexId> point; // of each own vertex, or noVertex
  };

  void AddPoints(const Piece& piece)
  {
    Shown& shown = this->ByPiece[piece.id];
    shown.piece = &piece;
    shown.point.assign(piece.ownVertices, noVertex);
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      if (this->View.ShownAt(piece, v) == piece.id.resolution)
      {
        shown.point[v] = static_cast<VertexId>(this->Output.points.size());
        shown.any = true;
        this->Output.points.push_back(piece.positions[v]);
        this->Output.sources.push_back({ piece.id.resolution, piece.keys[v] });
      }
    }
    if (piece.ownVertices > 0 && piece.id.resolution < this->View.Stitch())
    {
      this->RankBegin[piece.keys[0]] = &shown;
    }
  }

  void AddTriangles(const Piece& piece)
  {
    // Where each vertex of the piece goes: a point, or nowhere because it lies above the cut.
    std::vector<VertexId> target(piece.VertexCount(), noVertex);
    std::vector<std::uint8_t> itself(piece.VertexCount(), 0);
    for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
    {
      const Resolution shownAt = this->View.ShownAt(piece, v);
      itself[v] = shownAt == piece.id.resolution;
      if (shownAt <= piece.id.resolution)
      {
        target[v] = this->PointOf(piece, v, shownAt);
      }
    }
    for (const Triangle& t : piece.triangles)
    {
      const Triangle moved{ target[t[0]], target[t[1]], target[t[2]] };
      const bool any = itself[t[0]] || itself[t[1]] || itself[t[2]];
      const bool whole = moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex;
      if (any && whole && moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0])
      {
        this->Output.triangles.push_back(RotateLowestFirst(moved));
      }
    }
  }

  // The point arrays that all pieces with a point have, tuples in the order of the points.
  void AddAttributes()
  {
    std::vector<const Shown*> showing;
    for (const Piece* piece : this->Pieces)
    {
      const Shown& shown = this->ByPiece.find(piece->id)->second;
      if (shown.any)
      {
        showing.push_back(&shown);
      }
    }
    if (showing.empty())
    {
      return;
    }
    for (const Attribute& array : showing.front()->piece->attributes)
    {
      Attribute values{ array.Info(), {} };
      const bool all = array.association == AttributeAssociation::Point &&
                       std::all_of(showing.begin(), showing.end(),
                         [&](const Shown* shown) { return AppendShown(*shown, values); });
      if (all)
      {
        this->Output.attributes.push_back(std::move(values));
      }
    }
  }

  // False where the piece has no such array.
  static bool AppendShown(const Shown& shown, Attribute& values)
  {
    const Attribute* array = FindAttribute(shown.piece->attributes, values);
    for (std::uint32_t v = 0; array && v < shown.piece->ownVertices; ++v)
    {
      if (shown.point[v] != noVertex)
      {
        values.Append(*array, v);
      }
    }
    return array != nullptr;
  }

  // The point that shows vertex `v` of `piece` at resolution `shownAt`, which is not finer than the
  // piece.
  VertexId PointOf(const Piece& piece, std::uint32_t v, Resolution shownAt) const
  {
    if (shownAt < this->View.Stitch())
    {
      const VertexKey rank =
        piece.id.resolution < this->View.Stitch() ? piece.keys[v] : this->View.BaseRank(piece, v);
      auto entry = this->RankBegin.upper_bound(rank);
      if (entry == this->RankBegin.begin())
      {
        return noVertex;
      }
      --entry;
      const VertexKey local = rank - entry->first;
      return local < entry->second->point.size()
               ? entry->second->point[static_cast<std::size_t>(local)]
               : noVertex;
    }
    const VertexKey key = piece.keys[v];
    const auto entry =
      this->ByPiece.find(PieceOfPartition(shownAt, PartitionOfKey(key), this->C.depths));
    if (entry == this->ByPiece.end())
    {
      return noVertex;
    }
    const std::uint32_t local = CutView::IntervalOf(*entry->second.piece, key);
    return local == noVertex ? noVertex : entry->second.point[local];
  }

  const Cut& C;
  const CutView& View;
  std::vector<const Piece*> Pieces;
  std::map<PieceId, Shown> ByPiece;
  std::map<VertexKey, const Shown*> RankBegin; // first rank of each base piece below S
  Surface Output;
};

}

Status CheckCut(const Cut& cut)
{
  const std::size_t partitions = std::size_t{ 1 } << cut.depths.partition;
  if (!cut.base.IsOriginal() && cut.base.Depth() > cut.depths.finest)
  {
    return Error{ ErrorCode::InvalidArgument, "level " + std::to_string(cut.base.Depth()) +
                                                " is finer than the finest, " +
                                                std::to_string(cut.depths.finest) };
  }
  if (!cut.refined.empty() && cut.refined.size() != partitions)
  {
    return Error{ ErrorCode::InvalidArgument, std::to_string(cut.refined.size()) +
                                                " resolutions for " + std::to_string(partitions) +
                                                " partitions" };
  }
  for (std::size_t p = 0; p < cut.refined.size(); ++p)
  {
    if (!cut.refined[p] || cut.refined[p]->IsOriginal())
    {
      continue;
    }
    const unsigned depth = cut.refined[p]->Depth();
    if (depth < cut.depths.stitch || depth > cut.depths.finest)
    {
      return Error{ ErrorCode::InvalidArgument,
        "partition " + std::to_string(p) + ": level " + std::to_string(depth) +
          " is not between the stitch depth " + std::to_string(cut.depths.stitch) +
          " and the finest level " + std::to_string(cut.depths.finest) };
    }
  }
  return {};
}

std::vector<PieceId> MissingPieces(const Cut& cut, const PieceLookup& lookup)
{
  std::vector<PieceId> missing;
  CutView(cut, lookup).Gather(missing);
  return missing;
}

Result<Surface> DrawSurface(const Cut& cut, const PieceLookup& lookup)
{
  KDSTREAM_TRY(CheckCut(cut));
  std::vector<PieceId> missing;
  CutView view(cut, lookup);
  std::vector<const Piece*> pieces = view.Gather(missing);
  if (!missing.empty())
  {
    return Error{ ErrorCode::NotFound, std::to_string(missing.size()) + " pieces are not loaded" };
  }
  return Drawer(cut, view, std::move(pieces)).Draw();
}

}
