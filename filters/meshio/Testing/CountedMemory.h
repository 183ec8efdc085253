// SPDX-License-Identifier: BSD-3-Clause
// Counts every allocation of a test program: include it in one source only.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <new>

#include <malloc.h>

namespace
{

std::size_t liveBytes = 0;
std::size_t peakBytes = 0;

void* CountedAllocation(std::size_t size)
{
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr)
  {
    throw std::bad_alloc();
  }
  liveBytes += malloc_usable_size(memory);
  peakBytes = std::max(peakBytes, liveBytes);
  return memory;
}

void CountedRelease(void* memory) noexcept
{
  if (memory != nullptr)
  {
    liveBytes -= malloc_usable_size(memory);
    std::free(memory);
  }
}

}

void* operator new(std::size_t size)
{
  return CountedAllocation(size);
}
void* operator new[](std::size_t size)
{
  return CountedAllocation(size);
}
void operator delete(void* memory) noexcept
{
  CountedRelease(memory);
}
void operator delete[](void* memory) noexcept
{
  CountedRelease(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
  CountedRelease(memory);
}
void operator delete[](void* memory, std::size_t) noexcept
{
  CountedRelease(memory);
}
