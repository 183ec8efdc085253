// SPDX-License-Identifier: BSD-3-Clause
// Collects the geometric errors of a resolution's vertices until all are known: a store's figures
// depend on all of them, and a level may have more than fit in memory. Only for StoreWriter.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace kdstream
{

class GeometricErrorList
{
public:
  struct Summary
  {
    // Not exceeded by 99 of 100: the (n - 1) × 99 / 100-th smallest of n, counted from 0.
    float at99 = 0;
    float largest = 0;
  };

  // folder: for a temporary file without a name, used if there are more than `inMemory`.
  explicit GeometricErrorList(
    std::filesystem::path folder, std::size_t inMemory = std::size_t{ 1 } << 20);
  GeometricErrorList(const GeometricErrorList&) = delete;
  GeometricErrorList& operator=(const GeometricErrorList&) = delete;
  ~GeometricErrorList();

  // REQUIRES: none is negative or NaN. Errors: InputOutput.
  Status Add(std::span<const float> geometricErrors);
  // The exact figures of all geometric errors that were added, whatever their order; zeros if there
  // are none. Empties the list. O(n), two passes; memory inMemory floats and 512 KiB. Errors:
  // InputOutput.
  Result<Summary> Finish();

private:
  Status Flush();
  template <class Visit>
  Status ForEach(const Visit& visit) const;

  std::filesystem::path Folder;
  std::size_t InMemory;
  std::vector<float> Last; // the latest errors, not yet in the file
  std::uint64_t InFile = 0;
  int File = -1;
};

}
