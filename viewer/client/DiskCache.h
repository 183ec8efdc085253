// SPDX-License-Identifier: BSD-3-Clause
// Blobs that came from servers, kept on the disk (paper section 5.2). Part of step "receive" of the
// pipeline picture.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// The key of an entry: a blob of the build `digest` of a model that the server `origin` has.
// Descriptions and lists of models are entries, too.
struct CacheKey
{
  std::string origin; // "http://HOST:PORT"
  std::string digest;
  std::string name; // "levels/12/3"
};

// One SQLite file, which several programs may use at the same time. The least recently used entries
// are removed first. The cache writes entries on a thread of its own. An entry that is damaged on
// the disk is deleted, and counts as missing. Threads: functions may be called from any thread.
class DiskCache
{
public:
  // Opens the cache in `folder`. A new folder is readable only by its owner; an existing one is not
  // changed; the file in it is private in both cases. A damaged file, or a file of another version,
  // is replaced. mostBytes: the limit for the contents of all entries. If the folder cannot be
  // written to, or another program keeps the file busy, existing entries are read, and new ones are
  // not kept. A link, or a file of another user, is not touched. onTrouble: called once with the
  // reason, by this function or from the cache's thread, if nothing can be kept any more (a full
  // disk), or not for a while (a busy file, Remedy::Retry); may be empty. Errors: InputOutput if
  // the file can neither be read nor written.
  static Result<std::shared_ptr<DiskCache>> Open(const std::filesystem::path& folder,
    std::uint64_t mostBytes, std::function<void(const Error& why)> onTrouble = {});
  // Waits for the last entries to be written.
  ~DiskCache();

  // The bytes of an entry; nothing if there is no such entry.
  std::optional<std::vector<std::uint8_t>> Find(const CacheKey& key);
  // Keeps these bytes from now on.
  void Put(const CacheKey& key, std::vector<std::uint8_t> bytes);

private:
  class File;
  explicit DiskCache(std::unique_ptr<File> file);
  std::unique_ptr<File> Kept;
};

}
