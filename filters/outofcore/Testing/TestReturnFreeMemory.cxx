// SPDX-License-Identifier: BSD-3-Clause
// When freed memory goes back to the system.
#include "filters/outofcore/files/ReturnFreeMemory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <vector>

#include <unistd.h>

namespace kdstream
{
namespace
{

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
constexpr bool isGlibcMalloc = false;
#else
constexpr bool isGlibcMalloc = true;
#endif

std::uint64_t Resident()
{
  std::uint64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

TEST(FreeMemory, IsKeptUpToABound)
{
  if (!isGlibcMalloc)
  {
    GTEST_SKIP() << "another malloc";
  }
  constexpr std::size_t block = 1 << 16, blocks = 1024;
  std::vector<std::vector<char>> held;
  for (std::size_t i = 0; i < blocks; ++i)
  {
    held.emplace_back(block, 'x');
  }
  const std::vector<char> above(block, 'y'); // the heap does not shrink by itself
  const std::uint64_t full = Resident();
  held.resize(1);
  ReturnFreeMemory(full + block * blocks);
  EXPECT_GT(Resident(), full - block * blocks / 4);
  ReturnFreeMemory(full - block * blocks / 2);
  EXPECT_LT(Resident(), full - block * blocks / 2);
  EXPECT_EQ(above.back(), 'y');
}

TEST(FreeMemory, GoesBackWithoutABound)
{
  if (!isGlibcMalloc)
  {
    GTEST_SKIP() << "another malloc";
  }
  constexpr std::size_t block = 1 << 16, blocks = 1024;
  std::vector<std::vector<char>> held;
  for (std::size_t i = 0; i < blocks; ++i)
  {
    held.emplace_back(block, 'x');
  }
  const std::vector<char> above(block, 'y');
  const std::uint64_t full = Resident();
  held.resize(1);
  ReturnFreeMemory();
  EXPECT_LT(Resident(), full - block * blocks / 2);
  EXPECT_EQ(above.back(), 'y');
}

}
}
