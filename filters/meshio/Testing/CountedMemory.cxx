// SPDX-License-Identifier: BSD-3-Clause
// Replaces operator new of a test program: see CountedMemory.h.
#include "filters/meshio/Testing/CountedMemory.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#include <malloc.h>

std::size_t liveBytes = 0, peakBytes = 0;

namespace
{

void* CountedOrNull(std::size_t size) noexcept
{
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory != nullptr)
  {
    liveBytes += malloc_usable_size(memory);
    peakBytes = std::max(peakBytes, liveBytes);
  }
  return memory;
}

void* CountedAllocation(std::size_t size)
{
  void* memory = CountedOrNull(size);
  if (memory == nullptr)
  {
    throw std::bad_alloc();
  }
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
// Sorts allocate their buffers so, and free them by operator delete.
void* operator new(std::size_t size, const std::nothrow_t& /*no throw*/) noexcept
{
  return CountedOrNull(size);
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
