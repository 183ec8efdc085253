// SPDX-License-Identifier: BSD-3-Clause
// The files of a folder, for the web viewer: a URL's path to bytes, never outside the folder.
#pragma once

#include "filters/core/Result.h"
#include "server/session/Catalog.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace kdstream
{

struct StaticFile
{
  BlobBytes bytes;
  std::string contentType;
  std::string encoding; // "gzip", or empty
  bool varies = false;  // whether there are both, plain and gzip
};

class StaticFiles
{
public:
  static constexpr std::uintmax_t maximumBytes = std::uintmax_t{ 64 } << 20;

  // Errors: NotFound where `folder` is not a folder.
  static Result<StaticFiles> Open(const std::filesystem::path& folder);

  // The file at the path of a URL; for a folder, its index.html. Escapes (%20) are decoded once.
  // With `acceptGzip`, the bytes of FILE.gz if it lies beside FILE. Whether they are those of FILE
  // is not checked. Errors: InvalidArgument for malformed escapes; NotFound for everything but
  // regular files below the folder, so for hidden files, "..", and links that lead outside;
  // LimitExceeded for a file that is too large; InputOutput.
  Result<StaticFile> Read(std::string_view urlPath, bool acceptGzip = false) const;

private:
  explicit StaticFiles(std::filesystem::path root)
    : Root(std::move(root))
  {
  }
  std::filesystem::path Root; // canonical
};

}
