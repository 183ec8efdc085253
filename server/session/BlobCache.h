// SPDX-License-Identifier: BSD-3-Clause
// Blobs read from stores, shared by all clients: a blob is in memory once, however many clients get
// it. The most recently requested blobs stay in memory.
#pragma once

#include "filters/core/Result.h"
#include "filters/protocol/BlobId.h"
#include "server/session/Catalog.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <utility>

namespace kdstream
{

// All functions may be called from any thread.
class BlobCache
{
public:
  static constexpr std::size_t defaultBytes = std::size_t{ 256 } << 20;

  // Identifies one build of a model. The model's id does not, because another build may have the
  // same id.
  using Model = std::uint64_t;

  // Keeps at most this number of bytes of blobs that nobody uses at present. 0: keeps none.
  explicit BlobCache(std::size_t mostBytes)
    : Most(mostBytes)
  {
  }

  Model AddModel();
  // Forgets the model's blobs. REQUIRES: no Get of them is in progress.
  void RemoveModel(Model model);

  // The blob, if it is in memory; else null.
  BlobBytes Find(Model model, const protocol::BlobId& blob);

  // The blob: from the cache, or what read() returns, a Result<BlobBytes>. Threads do not wait for
  // each other, because a disk may block one of them: if two threads read the same blob at the same
  // time, both return the bytes that were read first. (In a server, WorkerPool makes such reads
  // follow each other.) Errors: those of read(); they are not kept.
  template <class Read>
  Result<BlobBytes> Get(Model model, const protocol::BlobId& blob, const Read& read)
  {
    if (auto bytes = this->FindOrMiss(model, blob))
    {
      return bytes;
    }
    auto result = read();
    KDSTREAM_TRY(result);
    return this->Keep({ model, blob }, *result);
  }

  // How many blobs were found and how many were read so far, and the number of bytes kept,
  // including those in use.
  CacheUse Use() const;

private:
  using Key = std::pair<Model, protocol::BlobId>;
  struct Entry
  {
    // The bytes, which can be found as long as somebody holds them.
    std::weak_ptr<const std::vector<std::uint8_t>> bytes;
    BlobBytes kept;                 // null if the blob is not in Recent
    std::list<Key>::iterator place; // in Recent, if kept
  };
  using EntryMap = std::map<Key, Entry>;

  BlobBytes FindOrMiss(Model model, const protocol::BlobId& blob);
  BlobBytes Touch(EntryMap::iterator entry);
  BlobBytes Keep(const Key& key, const BlobBytes& bytes);
  void LetGo(EntryMap::iterator entry);
  void Sweep();

  const std::size_t Most;
  mutable std::mutex Mutex;
  Model Models = 0;
  EntryMap Entries;
  std::list<Key> Recent; // the latest first
  std::size_t Bytes = 0; // of Recent
  std::uint64_t Hits = 0, Misses = 0;
};

}
