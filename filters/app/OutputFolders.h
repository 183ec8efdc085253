// SPDX-License-Identifier: BSD-3-Clause
// Folders for an output whose folders are not there yet.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// As CheckOutput of a file, for one whose folders may be missing: they are made, and removed again.
// Afterwards, until OutputFolders::Make, a program that ends has nothing to remove. Errors: those
// of both; Cancelled after an interrupt.
Result<std::filesystem::path> CheckOutputAndFolders(
  const std::string& file, const std::string& input);

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
