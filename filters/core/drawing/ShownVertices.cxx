// SPDX-License-Identifier: BSD-3-Clause
// Vertices and the nodes of a cut above them: see ShownVertices.h.
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{

namespace
{

template <class T>
void SortOnce(std::vector<T>& values)
{
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

bool AnyOf(const std::vector<PieceId>& asked, const std::set<PieceId>& changes)
{
  return std::any_of(changes.begin(), changes.end(),
    [&asked](PieceId id) { return std::binary_search(asked.begin(), asked.end(), id); });
}

}

// Which pieces take part follows from the base and what is active, so nothing else need be told to
// those that asked.
void ShownVertices::GoTo(const Cut& cut, std::vector<const Piece*> pieces)
{
  const Resolution base = BaseOf(cut);
  if (base != this->Base || cut.depths != this->C.depths)
  {
    this->ByPiece.clear();
  }
  Changes changes;
  std::set_symmetric_difference(cut.active.begin(), cut.active.end(), this->C.active.begin(),
    this->C.active.end(), std::inserter(changes, changes.end()));
  this->C = cut;
  this->Base = base;
  this->Stitch = Resolution::Level(cut.depths.stitch);
  this->TakePieces(std::move(pieces));
  for (Known* const known : this->Numbered)
  {
    const bool isNew = known->shown.empty();
    known->changed = isNew;
    if ((isNew || AnyOf(known->askedByOwn, changes)) && this->AskOwn(*known))
    {
      known->changed = true;
      changes.insert(known->piece->id);
    }
  }
  for (Known* const known : this->Numbered)
  {
    if (known->changed || AnyOf(known->askedByGhosts, changes))
    {
      known->changed |= this->AskGhosts(*known);
    }
  }
}

// Forgets pieces that have gone, and numbers the others.
void ShownVertices::TakePieces(std::vector<const Piece*> pieces)
{
  std::map<PieceId, Known> before = std::exchange(this->ByPiece, {});
  this->All = std::move(pieces);
  this->Numbered.clear();
  this->Numbers.clear();
  this->Owners = {};
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    const Piece& piece = *this->All[i];
    auto node = before.extract(piece.id);
    Known& known = node.empty() ? this->ByPiece[piece.id]
                                : this->ByPiece.insert(std::move(node)).position->second;
    known.piece = &piece;
    this->Numbered.push_back(&known);
    this->Numbers[piece.id] = i;
    if (piece.id.resolution < this->Stitch)
    {
      this->Owners.Add(piece, i);
    }
  }
}

void ShownVertices::ForgetAsked()
{
  this->AskedPieces.clear();
  this->AskedPartitions.clear();
  this->LastFinest.reset();
}

// Goes through the own vertices; whether any of them is shown by another resolution than before.
bool ShownVertices::AskOwn(Known& known)
{
  const Piece& piece = *known.piece;
  bool changed = known.shown.empty();
  known.shown.resize(piece.VertexCount(), above);
  this->ForgetAsked();
  for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
  {
    const Resolution shown = this->ShownOwn(piece, v);
    changed |= known.shown[v] != shown;
    known.shown[v] = shown;
  }
  this->NoteAsked(piece, known.askedByOwn);
  return changed;
}

// The same with the ghosts.
bool ShownVertices::AskGhosts(Known& known)
{
  const Piece& piece = *known.piece;
  this->ForgetAsked();
  bool changed = false;
  for (std::uint32_t v = piece.ownVertices; v < piece.VertexCount(); ++v)
  {
    const Resolution shown = this->ShownGhost(piece, v);
    changed |= known.shown[v] != shown;
    known.shown[v] = shown;
  }
  this->NoteAsked(piece, known.askedByGhosts);
  return changed;
}

// Also the pieces whose being active was asked for: those that clusters reach, and those that cover
// partitions.
void ShownVertices::NoteAsked(const Piece& piece, std::vector<PieceId>& asked) const
{
  asked = this->AskedPieces;
  SortOnce(asked);
  std::vector<std::uint32_t> partitions = this->AskedPartitions;
  SortOnce(partitions);
  const TreeDepths& depths = this->C.depths;
  for (const std::uint32_t partition : partitions)
  {
    for (unsigned d = depths.stitch; d <= depths.finest; ++d)
    {
      asked.push_back(PieceOfPartition(Resolution::Level(d), partition, depths));
    }
    asked.push_back(PieceOfPartition(Resolution::Original(), partition, depths));
  }
  if (!piece.reachNodes.empty())
  {
    const Resolution next = Resolution::Level(piece.id.resolution.Depth() + 1);
    std::vector<NodeId> nodes = piece.reachNodes;
    SortOnce(nodes);
    for (const NodeId node : nodes)
    {
      asked.push_back({ next, node });
    }
  }
  SortOnce(asked);
}

// Where an own vertex of another piece is shown, which is noted.
Resolution ShownVertices::ShownAtPlace(const Place& place)
{
  const PieceId id = this->All[place.piece]->id;
  if (this->AskedPieces.empty() || this->AskedPieces.back() != id)
  {
    this->AskedPieces.push_back(id);
  }
  return this->Numbered[place.piece]->shown[place.vertex];
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
