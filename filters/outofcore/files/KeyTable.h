// SPDX-License-Identifier: BSD-3-Clause
// A hash table that finds equal vertices of a bucket: step "weld" out of core and on several ranks.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace kdstream
{

// The distinct keys of a bucket, each with one vertex. All keys have the same size.
class KeyTable
{
public:
  explicit KeyTable(std::size_t keyBytes)
    : KeyBytes(keyBytes)
    , Slots(64, noVertex)
  {
  }

  // Returns the vertex stored with this key. If the key is new, stores `id` with it. The reference
  // is valid until the next call.
  VertexId& VertexOf(std::span<const std::byte> key, std::uint64_t hash, VertexId id)
  {
    if (2 * this->Ids.size() >= this->Slots.size())
    {
      this->Grow();
    }
    const auto mark = static_cast<std::uint32_t>(hash);
    std::size_t slot = mark & (this->Slots.size() - 1);
    for (; this->Slots[slot] != noVertex; slot = (slot + 1) & (this->Slots.size() - 1))
    {
      const VertexId entry = this->Slots[slot];
      if (this->Marks[entry] == mark &&
          std::memcmp(this->Keys.data() + entry * this->KeyBytes, key.data(), this->KeyBytes) == 0)
      {
        return this->Ids[entry];
      }
    }
    this->Slots[slot] = static_cast<VertexId>(this->Ids.size());
    this->Ids.push_back(id);
    this->Marks.push_back(mark);
    this->Keys.insert(this->Keys.end(), key.begin(), key.end());
    return this->Ids.back();
  }

  void Clear()
  {
    this->Ids.clear();
    this->Marks.clear();
    this->Keys.clear();
    std::fill(this->Slots.begin(), this->Slots.end(), noVertex);
  }

  // Bytes that a key takes at most: key, id and mark, twice while the vectors grow, and slots.
  static std::size_t BytesOf(std::size_t keyBytes) { return 2 * (keyBytes + 8) + 24; }

private:
  void Grow()
  {
    this->Slots.assign(2 * this->Slots.size(), noVertex);
    for (std::size_t entry = 0; entry < this->Marks.size(); ++entry)
    {
      std::size_t slot = this->Marks[entry] & (this->Slots.size() - 1);
      while (this->Slots[slot] != noVertex)
      {
        slot = (slot + 1) & (this->Slots.size() - 1);
      }
      this->Slots[slot] = static_cast<VertexId>(entry);
    }
  }

  std::size_t KeyBytes;
  std::vector<VertexId> Slots; // open addressing; indices of entries
  std::vector<VertexId> Ids;
  std::vector<std::uint32_t> Marks; // the lower half of each entry's hash
  std::vector<std::byte> Keys;
};

}
