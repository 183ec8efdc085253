// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/BlobCache.h"

#include <iterator>

namespace kdstream
{

BlobCache::Model BlobCache::AddModel()
{
  const std::lock_guard lock(this->Mutex);
  return ++this->Models;
}

void BlobCache::RemoveModel(Model model)
{
  const std::lock_guard lock(this->Mutex);
  for (auto entry = this->Entries.begin(); entry != this->Entries.end();)
  {
    const auto next = std::next(entry);
    if (entry->first.first == model)
    {
      this->LetGo(entry);
      this->Entries.erase(entry);
    }
    entry = next;
  }
}

BlobBytes BlobCache::Find(Model model, const protocol::BlobId& blob)
{
  const std::lock_guard lock(this->Mutex);
  const auto entry = this->Entries.find({ model, blob });
  return entry == this->Entries.end() ? nullptr : this->Touch(entry);
}

// The blob; null if the caller must read it.
BlobBytes BlobCache::FindOrMiss(Model model, const protocol::BlobId& blob)
{
  auto bytes = this->Find(model, blob);
  if (!bytes)
  {
    const std::lock_guard lock(this->Mutex);
    ++this->Misses;
  }
  return bytes;
}

// The entry's bytes. The entry becomes the most recently used one.
BlobBytes BlobCache::Touch(EntryMap::iterator entry)
{
  if (entry->second.kept)
  {
    this->Recent.splice(this->Recent.begin(), this->Recent, entry->second.place);
  }
  auto bytes = entry->second.bytes.lock();
  this->Hits += bytes ? 1 : 0;
  return bytes;
}

// Keeps the bytes. Returns the bytes that all requests for the blob get.
BlobBytes BlobCache::Keep(const Key& key, const BlobBytes& bytes)
{
  const std::lock_guard lock(this->Mutex);
  Entry& entry = this->Entries[key];
  if (auto first = entry.bytes.lock())
  {
    return first;
  }
  if (bytes->size() <= this->Most)
  {
    this->Recent.push_front(key);
    entry.place = this->Recent.begin();
    entry.kept = bytes;
    this->Bytes += bytes->size();
  }
  entry.bytes = bytes;
  while (this->Bytes > this->Most)
  {
    this->LetGo(this->Entries.find(this->Recent.back()));
  }
  this->Sweep();
  return bytes;
}

void BlobCache::LetGo(EntryMap::iterator entry)
{
  if (entry->second.kept)
  {
    this->Bytes -= entry->second.kept->size();
    this->Recent.erase(entry->second.place);
    entry->second.kept.reset();
  }
}

// A released blob that nobody uses any more leaves an entry. Removes these entries when there are
// more of them than of others.
void BlobCache::Sweep()
{
  constexpr std::size_t few = 1000;
  if (this->Entries.size() > few + 2 * this->Recent.size())
  {
    std::erase_if(this->Entries, [](const auto& entry) { return entry.second.bytes.expired(); });
  }
}

CacheUse BlobCache::Use() const
{
  const std::lock_guard lock(this->Mutex);
  return { this->Hits, this->Misses, this->Bytes };
}

}
