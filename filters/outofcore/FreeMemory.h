// Freed memory goes back to the system, where a memory limit is watched from outside.
#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace kdstream
{

// glibc keeps freed blocks of up to 32 MiB, in an arena a thread: the buffers of a pass would be
// held beside the cell that comes next.
inline void ReturnFreeMemory()
{
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}
