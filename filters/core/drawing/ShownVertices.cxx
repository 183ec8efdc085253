// SPDX-License-Identifier: BSD-3-Clause
// Finds the nodes of a cut above vertices: see ShownVertices.h.
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

namespace
{

// A number for a piece, in the order of pieces.
std::uint64_t KeyOf(PieceId id)
{
  const unsigned resolution =
    id.resolution.IsOriginal() ? Resolution::maximumLevel + 1U : id.resolution.Depth();
  return std::uint64_t{ resolution } << 32 | id.node;
}

void SortOnce(std::vector<std::uint64_t>& values)
{
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

bool AnyOf(const std::vector<std::uint64_t>& asked, const std::vector<std::uint64_t>& changes)
{
  return std::any_of(changes.begin(), changes.end(),
    [&asked](std::uint64_t key) { return std::binary_search(asked.begin(), asked.end(), key); });
}

// The elements of two ascending lists that are in only one of them.
std::vector<std::uint64_t> Differences(
  const std::vector<PieceId>& some, const std::vector<PieceId>& others)
{
  std::vector<std::uint64_t> keys;
  const auto add = [&keys](const std::vector<PieceId>& from, const std::vector<PieceId>& without)
  {
    for (const PieceId id : from)
    {
      if (!std::binary_search(without.begin(), without.end(), id))
      {
        keys.push_back(KeyOf(id));
      }
    }
  };
  add(some, others);
  add(others, some);
  return keys;
}

}

// Which pieces are in the cut follows from the base and the active pieces, so pieces that depend on
// others need no other information.
void ShownVertices::GoTo(const Cut& cut, std::vector<const Piece*> pieces)
{
  const Resolution base = BaseOf(cut);
  if (base != this->Base || cut.depths != this->C.depths)
  {
    this->Ids.clear();
  }
  // Pieces that were added to or removed from the active ones; later also pieces that show other
  // own vertices than before.
  Keys changes = Differences(cut.active, this->C.active);
  this->C = cut;
  this->Base = base;
  this->Stitch = Resolution::Level(cut.depths.stitch);
  this->TakePieces(std::move(pieces));
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    Known& known = *this->Numbered[i];
    const bool isNew = known.shown.empty();
    known.changed = isNew;
    if ((isNew || AnyOf(known.askedByOwn, changes)) && this->AskOwn(*this->All[i], known))
    {
      known.changed = true;
      changes.push_back(KeyOf(this->Ids[i]));
    }
  }
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    Known& known = *this->Numbered[i];
    if (known.changed || AnyOf(known.askedByGhosts, changes))
    {
      known.changed |= this->AskGhosts(*this->All[i], known);
    }
  }
}

// Forgets pieces that have gone, and numbers the others.
void ShownVertices::TakePieces(std::vector<const Piece*> pieces)
{
  const std::vector<PieceId> before = std::exchange(this->Ids, {});
  std::vector<std::unique_ptr<Known>> known = std::exchange(this->Numbered, {});
  this->All = std::move(pieces);
  this->Owners = {};
  this->LastInterval.reset();
  for (const Piece* piece : this->All)
  {
    if (piece->id.resolution < this->Stitch)
    {
      this->Owners.Add(*piece, this->Ids.size());
    }
    const auto place = std::lower_bound(before.begin(), before.end(), piece->id);
    const bool isKnown = place != before.end() && *place == piece->id;
    this->Numbered.push_back(isKnown
                               ? std::move(known[static_cast<std::size_t>(place - before.begin())])
                               : std::make_unique<Known>());
    this->Ids.push_back(piece->id);
  }
}

// Processes the own vertices; returns whether any of them is shown by another resolution than
// before.
bool ShownVertices::AskOwn(const Piece& piece, Known& known)
{
  bool changed = known.shown.empty();
  known.shown.resize(piece.VertexCount(), above);
  for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
  {
    const Resolution shown = this->ShownOwn(piece, v);
    changed |= known.shown[v] != shown;
    known.shown[v] = shown;
  }
  known.askedByOwn = this->TakeAsked(piece);
  return changed;
}

// The same for the ghosts.
bool ShownVertices::AskGhosts(const Piece& piece, Known& known)
{
  bool changed = false;
  for (std::uint32_t v = piece.ownVertices; v < piece.VertexCount(); ++v)
  {
    const Resolution shown = this->ShownGhost(piece, v);
    changed |= known.shown[v] != shown;
    known.shown[v] = shown;
  }
  known.askedByGhosts = this->TakeAsked(piece);
  return changed;
}

// The pieces that were consulted since the last call. Includes pieces that matter only if they
// become active: those that hold children of clusters, and those that cover partitions.
ShownVertices::Keys ShownVertices::TakeAsked(const Piece& piece)
{
  Keys asked = std::exchange(this->AskedPieces, {});
  SortOnce(asked);
  Keys partitions = std::exchange(this->AskedPartitions, {});
  this->LastFinest.reset();
  SortOnce(partitions);
  const TreeDepths& depths = this->C.depths;
  for (const std::uint64_t each : partitions)
  {
    const auto partition = static_cast<std::uint32_t>(each);
    for (unsigned d = depths.stitch; d <= depths.finest; ++d)
    {
      asked.push_back(KeyOf(PieceOfPartition(Resolution::Level(d), partition, depths)));
    }
    asked.push_back(KeyOf(PieceOfPartition(Resolution::Original(), partition, depths)));
  }
  Keys children(piece.childNodes.begin(), piece.childNodes.end());
  SortOnce(children);
  for (const std::uint64_t node : children)
  {
    asked.push_back(
      KeyOf({ Resolution::Level(piece.id.resolution.Depth() + 1), static_cast<NodeId>(node) }));
  }
  SortOnce(asked);
  return asked;
}

// The resolution at which an own vertex of another piece is shown. Notes that this piece was
// consulted.
Resolution ShownVertices::ShownAtPlace(const Place& place)
{
  const std::uint64_t key = KeyOf(this->Ids[place.piece]);
  if (this->AskedPieces.empty() || this->AskedPieces.back() != key)
  {
    this->AskedPieces.push_back(key);
  }
  return this->Numbered[place.piece]->shown[place.vertex];
}

// Looks for the finest ancestor of a vertex whose piece is in the cut.
ShownVertices::Ancestry ShownVertices::Ask(const Piece& piece, std::uint32_t v)
{
  const auto row = piece.AncestorsOf(v, this->C.depths);
  for (std::size_t k = row.size(); k-- > 0;)
  {
    const auto level = static_cast<unsigned>(PreviewLevel(this->C.depths) + k);
    if (const auto place = this->Owners.Find(level, row[k]))
    {
      const Resolution shown = this->ShownAtPlace(*place);
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
    const Resolution shown = cluster ? this->ShownAtPlace(*cluster) : above;
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
      return this->ShownAtPlace(*place);
    }
  }
  const Ancestry ancestry = this->Ask(piece, v);
  return ancestry.parentIsSplit && piece.id.resolution >= this->Stitch ? this->InPartition(piece, v)
                                                                       : ancestry.shown;
}

// For a reached own vertex of a level coarser than S: whether the pieces of all its children are
// active.
bool ShownVertices::IsSplit(const Piece& piece, std::uint32_t v) const
{
  if (piece.childBegin.empty())
  {
    return false; // coarser than R
  }
  const Resolution next = Resolution::Level(piece.id.resolution.Depth() + 1);
  const std::uint32_t begin = piece.childBegin[v], count = piece.childBegin[v + 1] - begin;
  const auto nodes = std::span(piece.childNodes).subspan(begin, count);
  return std::all_of(nodes.begin(), nodes.end(),
    [&](NodeId node) {
      return this->IsActive({ next, node });
    });
}

// For vertices in places where clusters of level S are reached, or where nothing coarser than S is
// shown.
Resolution ShownVertices::InPartition(const Piece& piece, std::uint32_t v)
{
  const std::uint32_t partition = PartitionOfKey(piece.keys[v]);
  if (!this->LastFinest || this->LastPartition != partition)
  {
    this->LastPartition = partition;
    this->AskedPartitions.push_back(partition);
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

std::optional<ShownVertices::Place> ShownVertices::IntervalAt(Resolution resolution, VertexKey key)
{
  if (this->LastInterval && this->Ids[this->LastInterval->piece].resolution == resolution)
  {
    const Piece& piece = *this->All[this->LastInterval->piece];
    const std::uint32_t v = this->LastInterval->vertex;
    if (piece.keys[v] <= key && PartitionOfKey(piece.keys[v]) == PartitionOfKey(key) &&
        (v + 1 == piece.ownVertices || key < piece.keys[v + 1]))
    {
      return this->LastInterval;
    }
  }
  const PieceId id = PieceOfPartition(resolution, PartitionOfKey(key), this->C.depths);
  const auto place = std::lower_bound(this->Ids.begin(), this->Ids.end(), id);
  if (place == this->Ids.end() || *place != id)
  {
    return {};
  }
  const auto number = static_cast<std::size_t>(place - this->Ids.begin());
  const std::uint32_t vertex = IntervalOf(*this->All[number], key);
  if (vertex == noVertex)
  {
    return {};
  }
  this->LastInterval = Place{ number, vertex };
  return this->LastInterval;
}

std::optional<ShownVertices::Place> ShownVertices::StitchClusterOf(VertexKey key)
{
  return this->IntervalAt(this->Stitch, key);
}

std::optional<ShownVertices::Place> ShownVertices::NodeAbove(std::size_t i, std::uint32_t v)
{
  const Piece& piece = *this->All[i];
  const Resolution shown = this->Numbered[i]->shown[v];
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
  const auto row = this->LineageOf(i, v).ranks;
  const std::size_t place = shown.Depth() - PreviewLevel(this->C.depths);
  return place < row.size() ? this->Owners.Find(shown.Depth(), row[place]) : std::nullopt;
}

// For own vertices finer than S, the ancestors come from their cluster of level S.
Lineage ShownVertices::LineageOf(std::size_t i, std::uint32_t v)
{
  const Piece& piece = *this->All[i];
  Lineage lineage;
  lineage.ranks = piece.AncestorsOf(v, this->C.depths);
  if (piece.id.resolution >= this->Stitch && v < piece.ownVertices)
  {
    const auto cluster = this->StitchClusterOf(piece.keys[v]);
    if (cluster)
    {
      const Piece& its = *this->All[cluster->piece];
      lineage.stitch = its.keys[cluster->vertex];
      lineage.ranks = its.AncestorsOf(cluster->vertex, this->C.depths);
    }
  }
  return lineage;
}

}
