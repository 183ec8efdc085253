// SPDX-License-Identifier: BSD-3-Clause
// The folder of a tileset, and the files that its URIs name. Nothing outside the folder is read.
#pragma once

#include "filters/core/Result.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace kdstream
{

class TilesetFolder
{
public:
  // Opens the folder of the file. Errors: InputOutput.
  static Result<TilesetFolder> Open(const std::filesystem::path& tileset);

  // The file that `uri` names in the file `by`. Both files are relative to the folder. Errors:
  // InvalidInput, continuing a sentence: for a URI that leads out of the folder (by .., as an
  // absolute path, a URL, or through links), or to no file.
  Result<std::filesystem::path> Find(const std::filesystem::path& by, const std::string& uri) const;
  std::filesystem::path PathOf(const std::filesystem::path& below) const
  {
    return this->Folder / below;
  }

private:
  std::filesystem::path Folder, Real; // as given; with links resolved
};

// Reads the whole file. Errors: InputOutput; LimitExceeded for more than `most` bytes.
Result<std::string> ReadTileText(const std::filesystem::path& file, std::uint64_t most);
// Parses a JSON object. Errors: InvalidInput, continuing a sentence, and naming the byte.
Result<nlohmann::json> ParseTileJson(std::string_view text);

// The number in the bytes from `at` on, little-endian. REQUIRES: the bytes exist.
std::uint64_t NumberInTile(std::string_view bytes, std::size_t at, std::size_t size);

}
