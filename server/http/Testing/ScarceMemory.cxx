// SPDX-License-Identifier: BSD-3-Clause
// Replaces operator new of a test program: see ScarceMemory.h.
#include "server/http/Testing/ScarceMemory.h"

#include <cstdlib>
#include <new>

// Both kinds of new are replaced, because sorts allocate their buffers by the second kind, and free
// them by the same delete. They are not inlined, because g++ would report a mismatch of malloc and
// delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t& /*no throw*/) noexcept
{
  return kdstream::ScarceMemory::FailsNow(size) ? nullptr : std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void* operator new(std::size_t size)
{
  void* memory =
    kdstream::ScarceMemory::FailsNow(size) ? nullptr : std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr)
  {
    throw std::bad_alloc();
  }
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}
