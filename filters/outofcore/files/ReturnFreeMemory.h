// SPDX-License-Identifier: BSD-3-Clause
// Keeps the memory of a process with --memory small, as the system measures it: freed memory is
// returned at once, and all threads allocate from the same arenas. For the builders, between steps,
// and for kdstream-build when it begins. FreeMemory of filters/program/Program.h tells how much
// memory is free.
#pragma once

#include <cstdint>
#include <cstdlib>

#ifdef __GLIBC__
#include <cstdio>
#include <malloc.h>
#include <unistd.h>
#endif

namespace kdstream
{

// Resident bytes of the process; the maximum of the type if the system does not report them.
inline std::uint64_t ResidentBytes()
{
#ifdef __GLIBC__
  unsigned long long size = 0, resident = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r"))
  {
    const int read = std::fscanf(file, "%llu %llu", &size, &resident);
    std::fclose(file);
    if (read == 2)
    {
      return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    }
  }
#endif
  return UINT64_MAX;
}

// For a program with a memory limit: call it before the program starts threads. glibc gives each
// thread an arena of its own, which keeps freed memory: with a limit of 64 MiB the arenas of 16
// threads held three times as much.
inline void ShareArenas()
{
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 2);
#endif
}

// Returns freed memory to the system if the process holds more than `keep` bytes. glibc keeps freed
// blocks of up to 32 MiB, in one arena for each thread. So the buffers of one pass would still take
// memory while the next cell is processed. But returned memory must be filled with zeros when it is
// allocated again; therefore nothing is returned below `keep`.
inline void ReturnFreeMemory(std::uint64_t keep = 0)
{
#ifdef __GLIBC__
  if (keep == 0 || ResidentBytes() > keep)
  {
    malloc_trim(0);
  }
#else
  (void)keep;
#endif
}

}
