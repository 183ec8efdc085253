// SPDX-License-Identifier: BSD-3-Clause
// Counts every allocation of a test program that has CountedMemory.cxx among its sources, on one
// thread.
#pragma once

#include "filters/meshio/Testing/ReadHostile.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string_view>

extern std::size_t liveBytes, peakBytes;

namespace kdstream::test
{

// Runs ReadHostile with `limit`. It may take at most `most` bytes of memory in all, and must free
// them.
template <class OpenReader>
bool ReadCounted(
  const OpenReader& open, std::string_view bytes, std::size_t limit, std::size_t most)
{
  const MemoryFile file(bytes);
  const std::size_t before = liveBytes;
  peakBytes = liveBytes;
  const bool isMesh = ReadHostile(open, file, limit);
  EXPECT_LE(peakBytes - before, most) << bytes.size() << " bytes";
  EXPECT_EQ(liveBytes, before) << "everything is given back";
  return isMesh;
}

}
