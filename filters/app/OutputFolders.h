// SPDX-License-Identifier: BSD-3-Clause
// Folders for an output whose folders are not there yet.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <vector>

namespace kdstream
{

// The folders that were made for an output. Empty ones are removed again, unless Keep is called: a
// failed command leaves nothing.
class OutputFolders
{
public:
  // Makes the folders of `file` that are missing. Errors: InputOutput.
  static Result<OutputFolders> Make(const std::filesystem::path& file);

  OutputFolders() = default;
  OutputFolders(OutputFolders&& other) noexcept;
  OutputFolders& operator=(OutputFolders&& other) noexcept;
  ~OutputFolders();

  void Keep() { this->Made.clear(); }

private:
  std::vector<std::filesystem::path> Made; // each in the one before
};

}
