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

// What an entry is: a blob of the build `digest` of a model, as `origin` serves it; descriptions
// and lists are entries too.
struct CacheKey
{
  std::string origin; // "http://HOST:PORT"
  std::string digest;
  std::string name; // "levels/12/3"
};

// One SQLite file, which several programs may use at a time. What was used last stays longest.
// Entries are written by a thread of its own; one that was damaged on the disk is not found, and
// is deleted. Threads: any.
class DiskCache
{
public:
  // In `folder`, which is made, readable only by its owner; one that is there stays as it is, and
  // the file in it is only its owner's. Of another version's file, or a damaged one, nothing is
  // kept. mostBytes: of entries' contents.
  // Where the folder cannot be written to, what is there is read, and nothing is kept. So too where
  // another program keeps the file busy; nothing of it is lost. A link there, or a file of another
  // user's, is left alone.
  // onTrouble: called once, by this or from a thread of its own, where nothing more can be kept (a
  // full disk), or nothing for a while (another program keeps the file busy), with why; may be
  // empty. Errors: InputOutput where neither can be done.
  static Result<std::shared_ptr<DiskCache>> Open(const std::filesystem::path& folder,
    std::uint64_t mostBytes, std::function<void(const std::string& why)> onTrouble = {});
  // Writes what has been put.
  ~DiskCache();

  // The entry's bytes; nothing where there is none.
  std::optional<std::vector<std::uint8_t>> Find(const CacheKey& key);
  // Keeps these bytes from now on.
  void Put(const CacheKey& key, std::vector<std::uint8_t> bytes);

private:
  class File;
  explicit DiskCache(std::unique_ptr<File> file);
  std::unique_ptr<File> Kept;
};

}
