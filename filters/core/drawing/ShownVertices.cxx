// SPDX-License-Identifier: BSD-3-Clause
// Vertices and the nodes of a cut above them: see ShownVertices.h.
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

ShownVertices::ShownVertices(const Cut& cut, std::vector<const Piece*> pieces)
  : C(cut)
  , Base(BaseOf(cut))
  , Stitch(Resolution::Level(cut.depths.stitch))
  , All(std::move(pieces))
  , Shown(All.size())
{
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    const Piece& piece = *this->All[i];
    this->Shown[i].assign(piece.VertexCount(), above);
    this->Numbers[piece.id] = i;
    if (piece.id.resolution < this->Stitch)
    {
      this->Owners.Add(piece, i);
    }
  }
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    for (std::uint32_t v = 0; v < this->All[i]->ownVertices; ++v)
    {
      this->Shown[i][v] = this->ShownOwn(*this->All[i], v);
    }
  }
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    for (std::uint32_t v = this->All[i]->ownVertices; v < this->All[i]->VertexCount(); ++v)
    {
      this->Shown[i][v] = this->ShownGhost(*this->All[i], v);
    }
  }
}

// What the ancestors of a vertex say: the finest one whose piece takes part.
ShownVertices::Ancestry ShownVertices::Ask(const Piece& piece, std::uint32_t v)
{
  const auto row = piece.AncestorsOf(v, this->C.depths);
  for (std::size_t k = row.size(); k-- > 0;)
  {
    const auto level = static_cast<unsigned>(PreviewLevel(this->C.depths) + k);
    if (const auto place = this->Owners.Find(level, row[k]))
    {
      const Resolution shown = this->Shown[place->piece][place->vertex];
      return { k + 1 == row.size() && shown == above, shown };
    }
  }
  return { false, above };
}

Resolution ShownVertices::ShownOwn(const Piece& piece, std::uint32_t v)
{
  const Resolution resolution = piece.id.resolution;
  if (this->Base >= this->Stitch)
  {
    return this->InPartition(piece, v);
  }
  if (resolution > this->Stitch)
  {
    const auto cluster = this->StitchClusterOf(piece.keys[v]);
    const Resolution shown = cluster ? this->Shown[cluster->piece][cluster->vertex] : above;
    return shown >= this->Stitch ? this->InPartition(piece, v) : shown;
  }
  if (resolution > this->Base)
  {
    const Ancestry ancestry = this->Ask(piece, v);
    if (!ancestry.parentIsSplit)
    {
      return ancestry.shown;
    }
  }
  if (resolution == this->Stitch)
  {
    return this->InPartition(piece, v);
  }
  return this->IsSplit(piece, v) ? above : resolution;
}

Resolution ShownVertices::ShownGhost(const Piece& piece, std::uint32_t v)
{
  if (this->Base >= this->Stitch)
  {
    return this->InPartition(piece, v);
  }
  if (piece.id.resolution < this->Stitch)
  {
    if (const auto place = this->Owners.Find(piece.id.resolution.Depth(), piece.keys[v]))
    {
      return this->Shown[place->piece][place->vertex];
    }
  }
  const Ancestry ancestry = this->Ask(piece, v);
  return ancestry.parentIsSplit && piece.id.resolution >= this->Stitch ? this->InPartition(piece, v)
                                                                       : ancestry.shown;
}

// Of an own vertex of a level below S that is reached: whether all its children's pieces are there.
bool ShownVertices::IsSplit(const Piece& piece, std::uint32_t v) const
{
  if (piece.reachBegin.empty())
  {
    return false; // coarser than R
  }
  const Resolution next = Resolution::Level(piece.id.resolution.Depth() + 1);
  const std::uint32_t begin = piece.reachBegin[v], count = piece.reachBegin[v + 1] - begin;
  const auto nodes = std::span(piece.reachNodes).subspan(begin, count);
  return std::all_of(nodes.begin(), nodes.end(),
    [&](NodeId node) {
      return this->IsActive({ next, node });
    });
}

// Where clusters of level S are reached, or nothing is coarser.
Resolution ShownVertices::InPartition(const Piece& piece, std::uint32_t v)
{
  const std::uint32_t partition = PartitionOfKey(piece.keys[v]);
  if (!this->LastFinest || this->LastPartition != partition)
  {
    this->LastPartition = partition;
    this->LastFinest = this->FinestOf(partition);
  }
  return *this->LastFinest > piece.id.resolution ? above : *this->LastFinest;
}

// The finest active resolution >= S that covers a partition.
Resolution ShownVertices::FinestOf(std::uint32_t partition) const
{
  const TreeDepths& depths = this->C.depths;
  const Resolution least = std::max(this->Base, this->Stitch);
  if (least.IsOriginal() ||
      this->IsActive(PieceOfPartition(Resolution::Original(), partition, depths)))
  {
    return Resolution::Original();
  }
  for (unsigned d = depths.finest; d > least.Depth(); --d)
  {
    if (this->IsActive(PieceOfPartition(Resolution::Level(d), partition, depths)))
    {
      return Resolution::Level(d);
    }
  }
  return least;
}

bool ShownVertices::IsActive(PieceId id) const
{
  return std::binary_search(this->C.active.begin(), this->C.active.end(), id);
}

std::optional<ShownVertices::Place> ShownVertices::IntervalAt(
  Resolution resolution, VertexKey key) const
{
  const auto entry =
    this->Numbers.find(PieceOfPartition(resolution, PartitionOfKey(key), this->C.depths));
  if (entry == this->Numbers.end())
  {
    return {};
  }
  const std::uint32_t vertex = IntervalOf(*this->All[entry->second], key);
  return vertex == noVertex ? std::nullopt : std::optional(Place{ entry->second, vertex });
}

std::optional<ShownVertices::Place> ShownVertices::StitchClusterOf(VertexKey key) const
{
  return this->IntervalAt(this->Stitch, key);
}

std::optional<ShownVertices::Place> ShownVertices::NodeAbove(std::size_t i, std::uint32_t v)
{
  const Piece& piece = *this->All[i];
  const Resolution shown = this->Shown[i][v];
  if (shown == above)
  {
    return {};
  }
  if (shown == piece.id.resolution && v < piece.ownVertices)
  {
    return Place{ i, v };
  }
  if (shown >= this->Stitch)
  {
    return this->IntervalAt(shown, piece.keys[v]);
  }
  if (shown == piece.id.resolution)
  {
    return this->Owners.Find(shown.Depth(), piece.keys[v]);
  }
  auto row = piece.AncestorsOf(v, this->C.depths);
  if (row.empty())
  {
    // Of own vertices finer than S their cluster of level S knows.
    const auto cluster = this->StitchClusterOf(piece.keys[v]);
    row = cluster ? this->All[cluster->piece]->AncestorsOf(cluster->vertex, this->C.depths) : row;
  }
  const std::size_t place = shown.Depth() - PreviewLevel(this->C.depths);
  return place < row.size() ? this->Owners.Find(shown.Depth(), row[place]) : std::nullopt;
}

}
