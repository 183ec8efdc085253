// SPDX-License-Identifier: BSD-3-Clause
// Decoded pieces, kept in memory while they are shown, and afterwards as long as memory allows:
// step "keep" of the pipeline picture.
#include "viewer/session/model/PieceCache.h"

#include <utility>

namespace kdstream
{
namespace
{
template <class T>
std::size_t BytesOf(const std::vector<T>& values)
{
  return values.size() * sizeof(T);
}
}

std::size_t MemoryOf(const Piece& piece)
{
  std::size_t bytes = sizeof(Piece) + BytesOf(piece.positions) + BytesOf(piece.keys) +
                      BytesOf(piece.geometricErrors) + BytesOf(piece.ancestors) +
                      BytesOf(piece.childBegin) + BytesOf(piece.childNodes) +
                      BytesOf(piece.triangles) + BytesOf(piece.attributes);
  for (const Attribute& attribute : piece.attributes)
  {
    bytes += BytesOf(attribute.values) + attribute.name.size();
  }
  return bytes;
}

PieceCache::PieceCache(std::size_t limit)
  : Limit(limit)
{
}

void PieceCache::Touch(PieceId id, Entry& entry)
{
  this->ByUse.erase(entry.lastUse);
  entry.lastUse = ++this->Uses;
  this->ByUse[entry.lastUse] = id;
}

void PieceCache::Add(Piece piece)
{
  ++this->Changes;
  const PieceId id = piece.id;
  Entry& entry = this->Entries[id];
  this->Sum -= entry.bytes;
  entry.bytes = MemoryOf(piece);
  this->Sum += entry.bytes;
  entry.piece = std::make_unique<Piece>(std::move(piece));
  this->Touch(id, entry);
  this->Evict();
}

const Piece* PieceCache::Find(PieceId id)
{
  const auto found = this->Entries.find(id);
  if (found == this->Entries.end())
  {
    return nullptr;
  }
  this->Touch(id, found->second);
  return found->second.piece.get();
}

const Piece* PieceCache::Peek(PieceId id) const
{
  const auto found = this->Entries.find(id);
  return found == this->Entries.end() ? nullptr : found->second.piece.get();
}

void PieceCache::Pin(std::set<PieceId> pieces)
{
  this->Pinned = std::move(pieces);
  this->Evict();
}

void PieceCache::SetLimit(std::size_t limit)
{
  this->Limit = limit;
  this->Evict();
}

void PieceCache::Clear()
{
  ++this->Changes;
  this->Entries.clear();
  this->ByUse.clear();
  this->Pinned.clear();
  this->Sum = 0;
}

void PieceCache::Evict()
{
  for (auto use = this->ByUse.begin(); use != this->ByUse.end() && this->Sum > this->Limit;)
  {
    if (this->Pinned.count(use->second) != 0)
    {
      ++use;
      continue;
    }
    ++this->Changes;
    const auto entry = this->Entries.find(use->second);
    this->Sum -= entry->second.bytes;
    this->Entries.erase(entry);
    use = this->ByUse.erase(use);
  }
}

}
