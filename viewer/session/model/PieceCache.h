// SPDX-License-Identifier: BSD-3-Clause
// Decoded pieces, kept in memory while they are shown, and afterwards as long as memory allows:
// step "keep" of the pipeline picture.
#pragma once

#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>

namespace kdstream
{

// Bytes of memory of a piece, without the allocator's own.
std::size_t MemoryOf(const Piece& piece);

// Pieces by id. Pinned pieces stay, even if they exceed the limit; of the others the least recently
// used are evicted (LRU) when all together exceed the limit. All functions O(log pieces), except
// Pin, which is O(pieces).
class PieceCache
{
public:
  explicit PieceCache(std::size_t limit);

  // Adds or replaces.
  void Add(Piece piece);
  // The piece, or null; counts as a use. The pointer stays good until the next Add, Pin or Clear.
  const Piece* Find(PieceId id);
  // The same without counting as a use.
  const Piece* Peek(PieceId id) const;
  // These pieces are shown or about to be; all others may be evicted.
  void Pin(std::set<PieceId> pieces);
  void SetLimit(std::size_t limit);
  void Clear();

  std::size_t Bytes() const { return this->Sum; }
  std::size_t Size() const { return this->Entries.size(); }
  // Grows whenever a piece is added or evicted.
  std::uint64_t Version() const { return this->Changes; }

private:
  struct Entry
  {
    std::unique_ptr<Piece> piece;
    std::size_t bytes = 0;
    std::uint64_t lastUse = 0;
  };
  void Evict();
  void Touch(PieceId id, Entry& entry);

  std::size_t Limit;
  std::size_t Sum = 0;
  std::uint64_t Uses = 0;
  std::uint64_t Changes = 0;
  std::map<PieceId, Entry> Entries;
  std::map<std::uint64_t, PieceId> ByUse; // oldest first
  std::set<PieceId> Pinned;
};

}
