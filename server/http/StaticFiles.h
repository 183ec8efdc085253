// SPDX-License-Identifier: BSD-3-Clause
// Serves the files of a folder, for the web viewer: finds the bytes for a URL's path. Path
// traversal (..) is refused.
#pragma once

#include "filters/core/Result.h"
#include "server/session/Catalog.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace kdstream
{

struct StaticFile
{
  BlobBytes bytes;
  std::string contentType;
  std::string encoding; // "gzip", or empty
  bool varies = false;  // whether there are both a plain and a gzip version
};

// All functions may be called from any thread.
class StaticFiles
{
public:
  static constexpr std::uintmax_t maximumBytes = std::uintmax_t{ 64 } << 20;
  static constexpr std::uintmax_t keptBytes = std::uintmax_t{ 64 } << 20;

  // Called with the reason for a file that cannot be served. It is called once, and again only
  // after the file could be served, or after Forget. From any thread.
  using Report = std::function<void(const std::string& file, const std::string& what)>;

  // Errors: NotFound if `folder` is not a folder.
  static Result<StaticFiles> Open(const std::filesystem::path& folder, Report report = {});

  // The file at the path of a URL; for a folder, its index.html. Escapes (%20) are decoded once.
  // With `acceptGzip`, the bytes of FILE.gz if there is such a file; it is not checked that FILE.gz
  // is FILE compressed. Errors: InvalidArgument for malformed escapes; NotFound for everything
  // except regular files below the folder, which excludes hidden files, "..", and links that lead
  // outside; LimitExceeded for a file that is too large; InputOutput. Copies of this object share
  // the files that were read; these stay in memory, up to keptBytes, until Forget.
  Result<std::shared_ptr<const StaticFile>> Read(
    std::string_view urlPath, bool acceptGzip = false) const;

  // The file, if it is in memory, else null.
  std::shared_ptr<const StaticFile> Find(std::string_view urlPath, bool acceptGzip = false) const;

  // Call this when the files may have changed.
  void Forget() const;

private:
  struct Kept;
  StaticFiles(std::filesystem::path root, Report report);
  void Tell(const std::string& relative, const Error& error) const;
  Result<StaticFile> ReadFile(const std::filesystem::path& relative, bool acceptGzip) const;

  std::filesystem::path Root; // canonical
  std::shared_ptr<Kept> Memory;
};

}
