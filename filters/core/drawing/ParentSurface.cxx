// SPDX-License-Identifier: BSD-3-Clause
// Finds points of the previous surface: see ParentSurface.h.
#include "filters/core/drawing/ParentSurface.h"

#include <algorithm>
#include <limits>

namespace kdstream
{

std::optional<ParentPoint> ParentSurface::Find(PieceId piece, std::uint32_t vertex) const
{
  const auto part = FindPart(this->Parts, piece);
  if (part == this->Parts.end())
  {
    return {};
  }
  const auto& own = (*part)->own;
  const auto place = std::lower_bound(own.begin(), own.end(), vertex);
  return place != own.end() && *place == vertex
           ? std::optional(ParentPoint{ static_cast<std::uint32_t>(part - this->Parts.begin()),
               static_cast<std::uint32_t>(place - own.begin()) })
           : std::nullopt;
}

std::optional<ParentPoint> ParentSurface::FindAbove(
  const Surface::Source& vertex, const Lineage& lineage) const
{
  const unsigned stitch = this->Depths.stitch, coarsest = PreviewLevel(this->Depths);
  std::optional<ParentPoint> found;
  if (vertex.resolution >= Resolution::Level(stitch))
  {
    if (vertex.resolution.IsOriginal())
    {
      found = this->FindInterval(vertex.resolution, vertex.key, vertex.key);
    }
    const unsigned finest =
      vertex.resolution.IsOriginal() ? this->Depths.finest : vertex.resolution.Depth();
    const VertexKey least = lineage.stitch.value_or(this->LeastOf(vertex.key));
    for (unsigned level = finest + 1; !found && level-- > stitch;)
    {
      found = this->FindInterval(Resolution::Level(level), vertex.key, least);
    }
  }
  else
  {
    found = this->FindRank(vertex.resolution.Depth(), vertex.key);
  }
  for (std::size_t k = lineage.ranks.size(); !found && k-- > 0;)
  {
    found = this->FindRank(static_cast<unsigned>(coarsest + k), lineage.ranks[k]);
  }
  return found;
}

// Used if a vertex's cluster of level S is not known: the lowest key that can belong to this
// cluster. If the surface has coarser parts, a key above all keys, so that nothing is found.
VertexKey ParentSurface::LeastOf(VertexKey key) const
{
  const bool anyCoarser = !this->Parts.empty() && this->Parts.front()->piece.resolution <
                                                    Resolution::Level(this->Depths.stitch);
  return anyCoarser ? std::numeric_limits<VertexKey>::max() : MakeKey(PartitionOfKey(key), 0);
}

// The last own point of a part whose key is at most `key`.
std::optional<ParentPoint> ParentSurface::LastUpTo(
  SurfacePartList::const_iterator part, VertexKey key) const
{
  const auto& sources = (*part)->surface.sources;
  const auto end = sources.begin() + static_cast<std::ptrdiff_t>((*part)->own.size());
  const auto place = std::partition_point(
    sources.begin(), end, [key](const Surface::Source& source) { return source.key <= key; });
  return place == sources.begin()
           ? std::nullopt
           : std::optional(ParentPoint{ static_cast<std::uint32_t>(part - this->Parts.begin()),
               static_cast<std::uint32_t>(place - sources.begin() - 1) });
}

// The cluster of a resolution >= S whose interval contains a key. Clusters with keys below `least`
// belong to another cluster of level S, and do not count.
std::optional<ParentPoint> ParentSurface::FindInterval(
  Resolution resolution, VertexKey key, VertexKey least) const
{
  const auto part =
    FindPart(this->Parts, PieceOfPartition(resolution, PartitionOfKey(key), this->Depths));
  const auto found = part == this->Parts.end() ? std::nullopt : this->LastUpTo(part, key);
  return found && (*part)->surface.sources[found->point].key >= least ? found : std::nullopt;
}

// The cluster of a level coarser than S. Ranks ascend from piece to piece.
std::optional<ParentPoint> ParentSurface::FindRank(unsigned level, VertexKey rank) const
{
  const Resolution resolution = Resolution::Level(level);
  const auto behind = std::partition_point(this->Parts.begin(), this->Parts.end(),
    [&](const auto& part)
    {
      const Resolution its = part->piece.resolution;
      return its < resolution || (its == resolution && part->surface.sources.front().key <= rank);
    });
  if (behind == this->Parts.begin() || (*(behind - 1))->piece.resolution != resolution)
  {
    return {};
  }
  const auto found = this->LastUpTo(behind - 1, rank);
  return found && (*(behind - 1))->surface.sources[found->point].key == rank ? found : std::nullopt;
}

}
