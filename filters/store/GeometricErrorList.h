// SPDX-License-Identifier: BSD-3-Clause
// The geometric errors of a resolution's vertices, until all are known: a store's figures depend on
// all of them, and a level may have more than fit the memory. Only for StoreWriter.
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
    float at99 = 0; // that 99 of 100 do not exceed: of n the (n - 1) × 99 / 100-th, from 0
    float largest = 0;
  };

  // folder: where a file for more than `inMemory` goes; it has no name there.
  explicit GeometricErrorList(
    std::filesystem::path folder, std::size_t inMemory = std::size_t{ 1 } << 20);
  GeometricErrorList(const GeometricErrorList&) = delete;
  GeometricErrorList& operator=(const GeometricErrorList&) = delete;
  ~GeometricErrorList();

  // None is negative or NaN. Errors: InputOutput.
  Status Add(std::span<const float> geometricErrors);
  // The figures of all geometric errors that were added, exactly, whatever their order; zeros if
  // there are none. Empties the list. O(n), two passes; memory inMemory floats and 512 KiB. Errors:
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
