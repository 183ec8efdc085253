// SPDX-License-Identifier: BSD-3-Clause
// When freed memory is returned to the system.
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

// Allocates 64 MiB in blocks, and frees all but the first. Another block is allocated after them,
// so that the heap does not shrink by itself.
class FreeMemory : public testing::Test
{
protected:
  void SetUp() override
  {
    if (!isGlibcMalloc)
    {
      GTEST_SKIP() << "another malloc";
    }
    for (std::size_t i = 0; i < blocks; ++i)
    {
      this->Held.emplace_back(block, 'x');
    }
    this->Last.assign(block, 'y');
    this->Full = Resident();
    this->Held.resize(1);
  }

  void TearDown() override { EXPECT_TRUE(!isGlibcMalloc || this->Last.back() == 'y'); }

  static constexpr std::size_t block = 1 << 16, blocks = 1024;
  std::uint64_t Full = 0; // resident bytes before blocks were freed

private:
  std::vector<std::vector<char>> Held;
  std::vector<char> Last;
};

TEST_F(FreeMemory, IsKeptUpToABound)
{
  ReturnFreeMemory(this->Full + block * blocks);
  EXPECT_GT(Resident(), this->Full - block * blocks / 4);
  ReturnFreeMemory(this->Full - block * blocks / 2);
  EXPECT_LT(Resident(), this->Full - block * blocks / 2);
}

TEST_F(FreeMemory, GoesBackWithoutABound)
{
  ReturnFreeMemory();
  EXPECT_LT(Resident(), this->Full - block * blocks / 2);
}

}
}
