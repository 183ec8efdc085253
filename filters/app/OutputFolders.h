// SPDX-License-Identifier: BSD-3-Clause
// Makes the missing folders of an output's path.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Like CheckOutput for a file, but folders of the path may be missing: they are made for the check,
// and removed again. So until OutputFolders::Make is called, a program that ends has nothing to
// remove. Errors: those of both; Cancelled after an interrupt.
Result<std::filesystem::path> CheckOutputAndFolders(
  const std::string& file, const std::string& input);

// The folders that were made for an output. Unless Keep is called, the empty ones are removed
// again, so that a failed command leaves nothing behind.
class OutputFolders
{
public:
  // Makes the missing folders of the path of `file`. Errors: InputOutput.
  static Result<OutputFolders> Make(const std::filesystem::path& file);

  OutputFolders() = default;
  OutputFolders(OutputFolders&& other) noexcept;
  OutputFolders& operator=(OutputFolders&& other) noexcept;
  ~OutputFolders();

  void Keep() { this->Made.clear(); }

private:
  std::vector<std::filesystem::path> Made; // each contains the next one
};

}
