// SPDX-License-Identifier: BSD-3-Clause
// A library for LD_PRELOAD: what a program asks of the system fails as Faults.h says. For tests of
// the program as it is, which cannot be asked to fail otherwise.
#include "server/app/Testing/Faults.h"

#include <dirent.h>
#include <dlfcn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <ctime>

extern "C"
{
  void* __libc_malloc(std::size_t);
  void* __libc_calloc(std::size_t, std::size_t);
  void* __libc_realloc(void*, std::size_t);
}

namespace
{

kdstream::Faults* faults = nullptr;

__attribute__((constructor)) void Begin()
{
  const char* const path = std::getenv(kdstream::faultsVariable);
  faults = path ? kdstream::MapFaults(path, false) : nullptr;
}

// The function of the name that would be called without this library.
template <class Function>
Function* Real(const char* name)
{
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

// Whether the call is to fail; then errno says why.
bool Strikes(const std::atomic<int> kdstream::Faults::*fault)
{
  const int reason = faults ? (faults->*fault).load() : 0;
  if (reason == kdstream::Faults::hangs)
  {
    const bool isMain = ::gettid() == ::getpid();
    faults->struck += isMain ? 0 : 1;
    while (!isMain && (faults->*fault).load() == kdstream::Faults::hangs)
    {
      ::usleep(1000);
    }
    return false;
  }
  if (reason != 0)
  {
    ++faults->struck;
    errno = reason;
  }
  return reason != 0;
}

// While a disk hangs that has the path.
void Await(const char* path)
{
  const int before = errno;
  if (faults && faults->hanging != 0 && path && std::strstr(path, kdstream::Faults::hangingWord))
  {
    ++faults->struck;
    while (faults->hanging != 0)
    {
      ::usleep(1000);
    }
  }
  errno = before;
}

// The same of an open file.
void Await(int file)
{
  if (faults && faults->hanging != 0)
  {
    char name[40], path[PATH_MAX];
    std::snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    const auto bytes = ::readlink(name, path, sizeof path - 1);
    path[bytes < 0 ? 0 : bytes] = 0;
    Await(path);
  }
}

bool IsRegular(int file)
{
  struct stat status = {};
  const int before = errno;
  const bool regular = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
  errno = before;
  return regular;
}

bool FailsToAllocate(std::size_t bytes)
{
  const auto every = faults ? faults->allocation.load(std::memory_order_relaxed) : 0;
  if (every == 0 || bytes < faults->leastBytes || (faults->allocations++ + 1) % every != 0)
  {
    return false;
  }
  ++faults->struck;
  errno = ENOMEM;
  return true;
}

mode_t ModeOf(int flags, std::va_list arguments)
{
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

bool FailsToOpen(int flags)
{
  return (flags & O_ACCMODE) == O_RDONLY && Strikes(&kdstream::Faults::opening);
}

template <class Seconds>
void Advance(Seconds& seconds)
{
  seconds += faults ? static_cast<Seconds>(faults->ahead.load()) : 0;
}

}

extern "C"
{

  ssize_t read(int file, void* data, std::size_t bytes)
  {
    static const auto real = Real<ssize_t(int, void*, std::size_t)>("read");
    Await(file);
    return faults && faults->reading != 0 && IsRegular(file) && Strikes(&kdstream::Faults::reading)
             ? -1
             : real(file, data, bytes);
  }

  ssize_t pread(int file, void* data, std::size_t bytes, off_t offset)
  {
    static const auto real = Real<ssize_t(int, void*, std::size_t, off_t)>("pread");
    Await(file);
    return Strikes(&kdstream::Faults::reading) ? -1 : real(file, data, bytes, offset);
  }

  ssize_t pread64(int file, void* data, std::size_t bytes, off64_t offset)
  {
    return pread(file, data, bytes, offset);
  }

  ssize_t write(int file, const void* data, std::size_t bytes)
  {
    static const auto real = Real<ssize_t(int, const void*, std::size_t)>("write");
    return faults && faults->writing != 0 && IsRegular(file) && Strikes(&kdstream::Faults::writing)
             ? -1
             : real(file, data, bytes);
  }

  ssize_t pwrite(int file, const void* data, std::size_t bytes, off_t offset)
  {
    static const auto real = Real<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
    return Strikes(&kdstream::Faults::writing) ? -1 : real(file, data, bytes, offset);
  }

  ssize_t pwrite64(int file, const void* data, std::size_t bytes, off64_t offset)
  {
    return pwrite(file, data, bytes, offset);
  }

  int open(const char* path, int flags, ...)
  {
    static const auto real = Real<int(const char*, int, mode_t)>("open");
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    Await(path);
    return FailsToOpen(flags) ? -1 : real(path, flags, mode);
  }

  int open64(const char* path, int flags, ...)
  {
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    return open(path, flags | O_LARGEFILE, mode);
  }

  int openat(int folder, const char* path, int flags, ...)
  {
    static const auto real = Real<int(int, const char*, int, mode_t)>("openat");
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    return FailsToOpen(flags) ? -1 : real(folder, path, flags, mode);
  }

  int openat64(int folder, const char* path, int flags, ...)
  {
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    return openat(folder, path, flags | O_LARGEFILE, mode);
  }

  // Those of the C library do not come by the functions above.
  std::FILE* fopen(const char* path, const char* mode)
  {
    static const auto real = Real<std::FILE*(const char*, const char*)>("fopen");
    return mode[0] == 'r' && Strikes(&kdstream::Faults::opening) ? nullptr : real(path, mode);
  }

  std::FILE* fopen64(const char* path, const char* mode)
  {
    return fopen(path, mode);
  }

  DIR* opendir(const char* path)
  {
    static const auto real = Real<DIR*(const char*)>("opendir");
    Await(path);
    return Strikes(&kdstream::Faults::opening) ? nullptr : real(path);
  }

  int stat(const char* path, struct stat* status)
  {
    static const auto real = Real<int(const char*, struct stat*)>("stat");
    Await(path);
    return real(path, status);
  }

  int lstat(const char* path, struct stat* status)
  {
    static const auto real = Real<int(const char*, struct stat*)>("lstat");
    Await(path);
    return real(path, status);
  }

  int fstat(int file, struct stat* status)
  {
    static const auto real = Real<int(int, struct stat*)>("fstat");
    Await(file);
    return real(file, status);
  }

  int accept4(int listener, sockaddr* address, socklen_t* length, int flags)
  {
    static const auto real = Real<int(int, sockaddr*, socklen_t*, int)>("accept4");
    return Strikes(&kdstream::Faults::accepting) ? -1 : real(listener, address, length, flags);
  }

  int accept(int listener, sockaddr* address, socklen_t* length)
  {
    return accept4(listener, address, length, 0);
  }

  void* malloc(std::size_t bytes)
  {
    return FailsToAllocate(bytes) ? nullptr : __libc_malloc(bytes);
  }

  void* calloc(std::size_t count, std::size_t bytes)
  {
    return FailsToAllocate(count * bytes) ? nullptr : __libc_calloc(count, bytes);
  }

  void* realloc(void* memory, std::size_t bytes)
  {
    return FailsToAllocate(bytes) ? nullptr : __libc_realloc(memory, bytes);
  }

  int clock_gettime(clockid_t clock, timespec* time)
  {
    static const auto real = Real<int(clockid_t, timespec*)>("clock_gettime");
    const int result = real(clock, time);
    if (result == 0 && clock == CLOCK_REALTIME)
    {
      Advance(time->tv_sec);
    }
    return result;
  }

  int gettimeofday(timeval* time, void* zone)
  {
    static const auto real = Real<int(timeval*, void*)>("gettimeofday");
    const int result = real(time, zone);
    if (result == 0)
    {
      Advance(time->tv_sec);
    }
    return result;
  }

  std::time_t time(std::time_t* place)
  {
    timespec now = {};
    ::clock_gettime(CLOCK_REALTIME, &now);
    if (place)
    {
      *place = now.tv_sec;
    }
    return now.tv_sec;
  }

  void* SSL_new(void* context)
  {
    static const auto real = Real<void*(void*)>("SSL_new");
    return Strikes(&kdstream::Faults::tls) ? nullptr : real(context);
  }
}
