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

  // Errors: NotFound where `folder` is no folder.
  static Result<StaticFiles> Open(const std::filesystem::path& folder);

  // The file at the path of a URL, index.html for a folder's. Escapes (%20) are taken back once.
  // Where FILE.gz lies beside FILE and `acceptGzip`, its bytes, which are taken for those of FILE:
  // they are not compared. Errors: InvalidArgument for wrong escapes; NotFound for everything that
  // is no plain file below the folder: hidden files, "..", and links that lead outside too;
  // LimitExceeded; InputOutput.
  Result<StaticFile> Read(std::string_view urlPath, bool acceptGzip = false) const;

private:
  explicit StaticFiles(std::filesystem::path root)
    : Root(std::move(root))
  {
  }
  std::filesystem::path Root; // canonical
};

}
