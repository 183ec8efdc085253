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

// The key of an entry: a blob of the build `digest` of a model, as `origin` serves it; descriptions
// and lists are entries too.
struct CacheKey
{
  std::string origin; // "http://HOST:PORT"
  std::string digest;
  std::string name; // "levels/12/3"
};

// One SQLite file, which several programs may use at a time. What was used last stays longest. A
// thread of its own writes entries. An entry that is damaged on the disk is deleted, and counts as
// missing. Threads: any.
class DiskCache
{
public:
  // Opens the cache in `folder`. A new folder is readable only by its owner; an existing one is not
  // changed; the file in it is private in both cases. A file of another version, or a damaged one,
  // is replaced. mostBytes: limit for the entries' contents. If the folder cannot be written to, or
  // another program keeps the file busy, existing entries are read, and new ones are not kept. A
  // link, or a file of another user, is not touched. onTrouble: called once with the reason, by
  // this function or from its own thread, if nothing more can be kept (a full disk), or nothing for
  // a while (a busy file); may be empty. Errors: InputOutput if the file can neither be read nor
  // written.
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
