// SPDX-License-Identifier: BSD-3-Clause
// A library for LD_PRELOAD that makes system calls of an unchanged program fail, as Faults.h
// specifies. It also records what happens to files (Recording.h). It can run main many times in one
// process (runsVariable), so that later runs need no loading.
#include "Testing/Faults/Faults.h"
#include "Testing/Faults/Recording.h"

#include <dirent.h>
#include <dlfcn.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/sendfile.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
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
  void* __libc_memalign(std::size_t, std::size_t);
}

namespace
{

using kdstream::Fault;
using kdstream::Faults;
using kdstream::FileAction;

Faults* faults = nullptr; // null until main begins, because no code can handle earlier failures
int record = -1;

// The function with this name that would be called without this library.
template <class Function>
Function* Real(const char* name)
{
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

// Whether this call must fail; then errno says why.
bool Strikes(Fault Faults::*kind)
{
  if (!faults)
  {
    return false;
  }
  auto& fault = faults->*kind;
  const auto call = fault.calls.fetch_add(1, std::memory_order_relaxed) + 1;
  const int reason = fault.reason.load(std::memory_order_relaxed);
  if (reason == 0 || call < fault.first || call > fault.last || call % fault.every != 0)
  {
    return false;
  }
  ++faults->struck;
  errno = reason;
  return true;
}

// Waits while the disk with this path hangs.
void Await(const char* path)
{
  const int before = errno;
  if (faults && faults->hanging != 0 && path && std::strstr(path, Faults::hangingWord))
  {
    ++faults->struck;
    while (faults->hanging != 0)
    {
      ::usleep(1000);
    }
  }
  errno = before;
}

// Does the same for an open file.
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

bool StateOf(int file, struct stat& state)
{
  const int before = errno;
  const bool known = ::syscall(SYS_fstat, file, &state) == 0;
  errno = before;
  return known;
}

bool IsRegular(int file)
{
  struct stat state = {};
  return faults && StateOf(file, state) && S_ISREG(state.st_mode);
}

bool FailsToRead(int file)
{
  return IsRegular(file) && Strikes(&Faults::reading);
}

bool FailsToWrite(int file)
{
  return file > STDERR_FILENO && IsRegular(file) && Strikes(&Faults::writing);
}

bool FailsToAllocate(std::size_t bytes)
{
  if (faults && bytes >= faults->leastBytes && Strikes(&Faults::allocation))
  {
    errno = ENOMEM;
    return true;
  }
  return false;
}

mode_t ModeOf(int flags, std::va_list arguments)
{
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

bool FailsToOpen(int flags)
{
  const bool reads = (flags & O_ACCMODE) == O_RDONLY;
  return Strikes(reads ? &Faults::opening : &Faults::creating);
}

template <class Seconds>
void Advance(Seconds& seconds)
{
  seconds += faults ? static_cast<Seconds>(faults->ahead.load()) : 0;
}

// --- Recording ----------------------------------------------------------------------------------

pthread_mutex_t recording = PTHREAD_MUTEX_INITIALIZER;

void Put(const void* data, std::size_t bytes)
{
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0)
  {
    const long put = ::syscall(SYS_write, record, from, bytes);
    if (put <= 0)
    {
      std::abort();
    }
    from += put;
    bytes -= static_cast<std::size_t>(put);
  }
}

// A path as an absolute path, if the folder that it is relative to can be determined.
struct Whole
{
  char text[2 * PATH_MAX] = {};
  explicit Whole(const char* path, int folder = AT_FDCWD)
  {
    if (record < 0 || !path)
    {
      return;
    }
    if (path[0] != '/')
    {
      char link[64];
      std::snprintf(
        link, sizeof(link), folder == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", folder);
      const long got = ::syscall(SYS_readlink, link, this->text, PATH_MAX);
      this->text[got > 0 ? got : 0] = 0;
      std::strcat(this->text, "/");
    }
    else if (const char* const rest = this->TakeDescriptor(path))
    {
      path = rest;
    }
    std::strncat(this->text, path, PATH_MAX - 1);
  }

private:
  // A folder that is held open is accessed by its descriptor: /proc/PID/fd/N. Returns the rest of
  // the path after it, or null.
  const char* TakeDescriptor(const char* path)
  {
    int process = 0, file = 0, end = 0;
    if (std::sscanf(path, "/proc/%d/fd/%d%n", &process, &file, &end) != 2 || end == 0)
    {
      return nullptr;
    }
    char link[64];
    std::snprintf(link, sizeof(link), "/proc/%d/fd/%d", process, file);
    const long got = ::syscall(SYS_readlink, link, this->text, PATH_MAX);
    this->text[got > 0 ? got : 0] = 0;
    return got > 0 ? path + end : nullptr;
  }
};

void Record(FileAction action, std::uint64_t inode, std::uint64_t offset, const void* data,
  std::size_t bytes, const char* path = "", const char* path2 = "")
{
  const int before = errno;
  kdstream::FileRecord entry;
  entry.action = action;
  entry.pathBytes = static_cast<std::uint32_t>(std::strlen(path));
  entry.path2Bytes = static_cast<std::uint32_t>(std::strlen(path2));
  entry.inode = inode;
  entry.offset = offset;
  entry.dataBytes = bytes;
  ::pthread_mutex_lock(&recording);
  Put(&entry, sizeof(entry));
  Put(path, entry.pathBytes);
  Put(path2, entry.path2Bytes);
  Put(data, bytes);
  ::pthread_mutex_unlock(&recording);
  errno = before;
}

// The offset of the next byte to write; -1 if the file is not recorded.
off_t PlaceOf(int file, struct stat& state)
{
  if (record < 0 || file <= STDERR_FILENO || !StateOf(file, state) || !S_ISREG(state.st_mode))
  {
    return -1;
  }
  const int flags = ::fcntl(file, F_GETFL);
  return (flags & O_APPEND) != 0 ? state.st_size : ::lseek(file, 0, SEEK_CUR);
}

void RecordWrite(off_t place, const struct stat& state, const void* data, ssize_t bytes)
{
  if (place >= 0 && bytes > 0)
  {
    Record(FileAction::Write, state.st_ino, static_cast<std::uint64_t>(place), data,
      static_cast<std::size_t>(bytes));
  }
}

void RecordSize(int file, off_t size)
{
  struct stat state = {};
  if (record >= 0 && StateOf(file, state))
  {
    Record(FileAction::Size, state.st_ino, static_cast<std::uint64_t>(size), nullptr, 0);
  }
}

// Records bytes that were written by a call that does not contain them.
void RecordCopied(int file, off_t place, const struct stat& state, ssize_t bytes)
{
  char block[1 << 14];
  while (place >= 0 && bytes > 0)
  {
    const long got = ::syscall(
      SYS_pread64, file, block, std::min(sizeof(block), static_cast<std::size_t>(bytes)), place);
    if (got <= 0)
    {
      std::abort(); // the file is open only for writing: this occurs in no test
    }
    RecordWrite(place, state, block, got);
    place += got;
    bytes -= got;
  }
}

bool IsThere(const char* path)
{
  struct stat state = {};
  const int before = errno;
  const bool isThere = ::syscall(SYS_newfstatat, AT_FDCWD, path, &state, AT_SYMLINK_NOFOLLOW) == 0;
  errno = before;
  return isThere;
}

template <class Open>
int Opened(const Whole& path, int flags, const Open& real)
{
  const bool wasThere = record >= 0 && IsThere(path.text);
  const int file = real();
  struct stat state = {};
  if (record < 0 || file < 0 || (flags & O_TMPFILE) == O_TMPFILE || !StateOf(file, state))
  {
    return file;
  }
  if ((flags & O_CREAT) != 0 && !wasThere)
  {
    Record(FileAction::Make, state.st_ino, 0, nullptr, 0, path.text);
  }
  else if ((flags & O_TRUNC) != 0)
  {
    Record(FileAction::Size, state.st_ino, 0, nullptr, 0);
  }
  return file;
}

int Recorded(
  int result, FileAction action, const Whole& path, const char* path2 = "", std::uint64_t inode = 0)
{
  if (record >= 0 && result == 0)
  {
    Record(action, inode, 0, nullptr, 0, path.text, path2);
  }
  return result;
}

std::uint64_t InodeOf(const char* path)
{
  struct stat state = {};
  return ::syscall(SYS_newfstatat, AT_FDCWD, path, &state, 0) == 0 ? state.st_ino : 0;
}

// --- Runs -------------------------------------------------------------------------------------

Faults* mapped = nullptr;
int (*realMain)(int, char**, char**) = nullptr;

__attribute__((constructor)) void Begin()
{
  if (const char* const path = std::getenv(kdstream::faultsVariable))
  {
    mapped = kdstream::MapFaults(path, false);
  }
  else if (const char* const one = std::getenv(kdstream::faultVariable))
  {
    static Faults alone;
    char kind[32] = {}, last[8] = {};
    unsigned long call = 0;
    int reason = 0;
    if (std::sscanf(one, "%31[a-z],%lu,%7[a-z],%d", kind, &call, last, &reason) == 4)
    {
      mapped = &alone;
      for (const auto& [name, fault] : kdstream::faultKinds)
      {
        if (std::strcmp(name, kind) == 0)
        {
          (alone.*fault).Fail(reason, call, last[1] == 'n' && !last[2] ? ~0ul : call);
        }
      }
    }
  }
  if (const char* const path = std::getenv(kdstream::recordVariable))
  {
    constexpr int high = 200; // not among the program's own descriptors
    const int file = ::open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
    record = ::fcntl(file, F_DUPFD_CLOEXEC, high);
    ::close(file);
  }
}

int Main(int argc, char** argv, char** environment)
{
  int asked = -1, answer = -1;
  const char* const runs = std::getenv(kdstream::runsVariable);
  if (runs && std::sscanf(runs, "%d,%d", &asked, &answer) == 2)
  {
    constexpr unsigned longest = 20; // seconds
    char go = 0;
    pid_t child = -1;
    while (::syscall(SYS_read, asked, &go, 1) == 1 && (child = ::fork()) != 0)
    {
      int status = -1;
      ::waitpid(child, &status, 0);
      (void)!::syscall(SYS_write, answer, &status, sizeof(status));
    }
    ::close(asked);
    ::close(answer);
    if (child != 0)
    {
      ::_exit(0);
    }
    ::alarm(longest); // SIGALRM ends a run that hangs
  }
  faults = mapped;
  return realMain(argc, argv, environment);
}

}

extern "C"
{

  int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
    void (*fini)(), void (*rtldFini)(), void* stackEnd)
  {
    realMain = main;
    const auto real = Real<int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(),
      void (*)(), void*)>("__libc_start_main");
    return real(Main, argc, argv, init, fini, rtldFini, stackEnd);
  }

  ssize_t read(int file, void* data, std::size_t bytes)
  {
    static const auto real = Real<ssize_t(int, void*, std::size_t)>("read");
    Await(file);
    return FailsToRead(file) ? -1 : real(file, data, bytes);
  }

  ssize_t readv(int file, const iovec* data, int count)
  {
    static const auto real = Real<ssize_t(int, const iovec*, int)>("readv");
    return FailsToRead(file) ? -1 : real(file, data, count);
  }

  ssize_t pread(int file, void* data, std::size_t bytes, off_t offset)
  {
    static const auto real = Real<ssize_t(int, void*, std::size_t, off_t)>("pread");
    Await(file);
    return Strikes(&Faults::reading) ? -1 : real(file, data, bytes, offset);
  }

  ssize_t pread64(int file, void* data, std::size_t bytes, off64_t offset)
  {
    return pread(file, data, bytes, offset);
  }

  ssize_t write(int file, const void* data, std::size_t bytes)
  {
    static const auto real = Real<ssize_t(int, const void*, std::size_t)>("write");
    if (FailsToWrite(file))
    {
      return -1;
    }
    struct stat state = {};
    const off_t place = PlaceOf(file, state);
    const ssize_t written = real(file, data, bytes);
    RecordWrite(place, state, data, written);
    return written;
  }

  ssize_t writev(int file, const iovec* data, int count)
  {
    static const auto real = Real<ssize_t(int, const iovec*, int)>("writev");
    if (FailsToWrite(file))
    {
      return -1;
    }
    struct stat state = {};
    off_t place = PlaceOf(file, state);
    const ssize_t written = real(file, data, count);
    for (ssize_t left = written; place >= 0 && left > 0; ++data)
    {
      const auto part = std::min(left, static_cast<ssize_t>(data->iov_len));
      RecordWrite(place, state, data->iov_base, part);
      place += part;
      left -= part;
    }
    return written;
  }

  ssize_t pwrite(int file, const void* data, std::size_t bytes, off_t offset)
  {
    static const auto real = Real<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
    if (Strikes(&Faults::writing))
    {
      return -1;
    }
    const ssize_t written = real(file, data, bytes, offset);
    struct stat state = {};
    RecordWrite(PlaceOf(file, state) < 0 ? -1 : offset, state, data, written);
    return written;
  }

  ssize_t pwrite64(int file, const void* data, std::size_t bytes, off64_t offset)
  {
    return pwrite(file, data, bytes, offset);
  }

  ssize_t copy_file_range(
    int from, off64_t* fromPlace, int to, off64_t* toPlace, std::size_t bytes, unsigned flags)
  {
    static const auto real =
      Real<ssize_t(int, off64_t*, int, off64_t*, std::size_t, unsigned)>("copy_file_range");
    if (Strikes(&Faults::writing))
    {
      return -1;
    }
    struct stat state = {};
    const off_t place = PlaceOf(to, state);
    const ssize_t copied = real(from, fromPlace, to, toPlace, bytes, flags);
    RecordCopied(to, place, state, copied);
    return copied;
  }

  ssize_t sendfile(int to, int from, off_t* offset, std::size_t bytes)
  {
    static const auto real = Real<ssize_t(int, int, off_t*, std::size_t)>("sendfile");
    if (FailsToWrite(to))
    {
      return -1;
    }
    struct stat state = {};
    const off_t place = PlaceOf(to, state);
    const ssize_t copied = real(to, from, offset, bytes);
    if (place >= 0 && copied > 0) // opened again, because the file may be open only for writing
    {
      char link[64];
      std::snprintf(link, sizeof(link), "/proc/self/fd/%d", to);
      const auto again = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, link, O_RDONLY));
      RecordCopied(again, place, state, copied);
      ::syscall(SYS_close, again);
    }
    return copied;
  }

  ssize_t sendfile64(int to, int from, off64_t* offset, std::size_t bytes)
  {
    return sendfile(to, from, offset, bytes);
  }

  int open(const char* path, int flags, ...)
  {
    static const auto real = Real<int(const char*, int, mode_t)>("open");
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    Await(path);
    return FailsToOpen(flags) ? -1
                              : Opened(Whole(path), flags, [&] { return real(path, flags, mode); });
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
    return FailsToOpen(flags)
             ? -1
             : Opened(Whole(path, folder), flags, [&] { return real(folder, path, flags, mode); });
  }

  int openat64(int folder, const char* path, int flags, ...)
  {
    std::va_list arguments;
    va_start(arguments, flags);
    const auto mode = ModeOf(flags, arguments);
    va_end(arguments);
    return openat(folder, path, flags | O_LARGEFILE, mode);
  }

  // The C library's own calls do not use the functions above, so these functions are replaced, too.
  std::FILE* fopen(const char* path, const char* mode)
  {
    static const auto real = Real<std::FILE*(const char*, const char*)>("fopen");
    const bool reads = mode[0] == 'r' && !std::strchr(mode, '+');
    const int flags = reads            ? O_RDONLY
                      : mode[0] == 'w' ? O_WRONLY | O_CREAT | O_TRUNC
                                       : O_WRONLY | O_CREAT;
    if (FailsToOpen(flags))
    {
      return nullptr;
    }
    std::FILE* stream = nullptr;
    Opened(Whole(path), flags,
      [&]
      {
        stream = real(path, mode);
        return stream ? ::fileno(stream) : -1;
      });
    return stream;
  }

  std::FILE* fopen64(const char* path, const char* mode)
  {
    return fopen(path, mode);
  }

  int mkostemp(char* path, int flags)
  {
    static const auto real = Real<int(char*, int)>("mkostemp");
    if (Strikes(&Faults::creating))
    {
      return -1;
    }
    const int file = real(path, flags);
    struct stat state = {};
    if (record >= 0 && file >= 0 && StateOf(file, state))
    {
      Record(FileAction::Make, state.st_ino, 0, nullptr, 0, Whole(path).text);
    }
    return file;
  }

  int mkostemp64(char* path, int flags)
  {
    return mkostemp(path, flags);
  }

  int mkstemp(char* path)
  {
    return mkostemp(path, 0);
  }

  int mkstemp64(char* path)
  {
    return mkostemp(path, 0);
  }

  char* mkdtemp(char* path)
  {
    static const auto real = Real<char*(char*)>("mkdtemp");
    char* const made = Strikes(&Faults::creating) ? nullptr : real(path);
    if (made)
    {
      Recorded(0, FileAction::MakeFolder, Whole(path), "", InodeOf(path));
    }
    return made;
  }

  int mkdir(const char* path, mode_t mode)
  {
    static const auto real = Real<int(const char*, mode_t)>("mkdir");
    const int made = Strikes(&Faults::creating) ? -1 : real(path, mode);
    return made < 0 ? made : Recorded(made, FileAction::MakeFolder, Whole(path), "", InodeOf(path));
  }

  int mkdirat(int folder, const char* path, mode_t mode)
  {
    static const auto real = Real<int(int, const char*, mode_t)>("mkdirat");
    const int made = Strikes(&Faults::creating) ? -1 : real(folder, path, mode);
    const Whole whole(path, folder);
    return made < 0 ? made : Recorded(made, FileAction::MakeFolder, whole, "", InodeOf(whole.text));
  }

  DIR* opendir(const char* path)
  {
    static const auto real = Real<DIR*(const char*)>("opendir");
    Await(path);
    return Strikes(&Faults::opening) ? nullptr : real(path);
  }

  int fsync(int file)
  {
    static const auto real = Real<int(int)>("fsync");
    if (Strikes(&Faults::syncing))
    {
      return -1;
    }
    struct stat state = {};
    if (record >= 0 && StateOf(file, state))
    {
      Record(FileAction::Sync, state.st_ino, 0, nullptr, 0);
    }
    return real(file);
  }

  int fdatasync(int file)
  {
    return fsync(file);
  }

  int ftruncate(int file, off_t size)
  {
    static const auto real = Real<int(int, off_t)>("ftruncate");
    if (Strikes(&Faults::sizing))
    {
      return -1;
    }
    const int result = real(file, size);
    if (result == 0)
    {
      RecordSize(file, size);
    }
    return result;
  }

  int ftruncate64(int file, off64_t size)
  {
    return ftruncate(file, size);
  }

  int fallocate(int file, int mode, off_t offset, off_t bytes)
  {
    static const auto real = Real<int(int, int, off_t, off_t)>("fallocate");
    return Strikes(&Faults::sizing) ? -1 : real(file, mode, offset, bytes);
  }

  int fallocate64(int file, int mode, off64_t offset, off64_t bytes)
  {
    return fallocate(file, mode, offset, bytes);
  }

  int rename(const char* from, const char* to)
  {
    static const auto real = Real<int(const char*, const char*)>("rename");
    return Strikes(&Faults::renaming)
             ? -1
             : Recorded(real(from, to), FileAction::Rename, Whole(from), Whole(to).text);
  }

  int renameat(int fromFolder, const char* from, int toFolder, const char* to)
  {
    static const auto real = Real<int(int, const char*, int, const char*)>("renameat");
    return Strikes(&Faults::renaming)
             ? -1
             : Recorded(real(fromFolder, from, toFolder, to), FileAction::Rename,
                 Whole(from, fromFolder), Whole(to, toFolder).text);
  }

  int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags)
  {
    static const auto real = Real<int(int, const char*, int, const char*, unsigned)>("renameat2");
    return Strikes(&Faults::renaming)
             ? -1
             : Recorded(real(fromFolder, from, toFolder, to, flags), FileAction::Rename,
                 Whole(from, fromFolder), Whole(to, toFolder).text);
  }

  int link(const char* from, const char* to)
  {
    static const auto real = Real<int(const char*, const char*)>("link");
    return Strikes(&Faults::renaming) ? -1
                                      : Recorded(real(from, to), FileAction::Link, Whole(from),
                                          Whole(to).text, InodeOf(from));
  }

  int linkat(int fromFolder, const char* from, int toFolder, const char* to, int flags)
  {
    static const auto real = Real<int(int, const char*, int, const char*, int)>("linkat");
    const Whole whole(from, fromFolder);
    return Strikes(&Faults::renaming)
             ? -1
             : Recorded(real(fromFolder, from, toFolder, to, flags), FileAction::Link, whole,
                 Whole(to, toFolder).text, record < 0 ? 0 : InodeOf(whole.text));
  }

  int unlink(const char* path)
  {
    static const auto real = Real<int(const char*)>("unlink");
    return Strikes(&Faults::removing) ? -1 : Recorded(real(path), FileAction::Remove, Whole(path));
  }

  int unlinkat(int folder, const char* path, int flags)
  {
    static const auto real = Real<int(int, const char*, int)>("unlinkat");
    return Strikes(&Faults::removing)
             ? -1
             : Recorded(real(folder, path, flags), FileAction::Remove, Whole(path, folder));
  }

  int rmdir(const char* path)
  {
    static const auto real = Real<int(const char*)>("rmdir");
    return Strikes(&Faults::removing) ? -1 : Recorded(real(path), FileAction::Remove, Whole(path));
  }

  int remove(const char* path)
  {
    static const auto real = Real<int(const char*)>("remove");
    return Strikes(&Faults::removing) ? -1 : Recorded(real(path), FileAction::Remove, Whole(path));
  }

  int fchmod(int file, mode_t mode)
  {
    static const auto real = Real<int(int, mode_t)>("fchmod");
    return Strikes(&Faults::owning) ? -1 : real(file, mode);
  }

  int fchown(int file, uid_t user, gid_t group)
  {
    static const auto real = Real<int(int, uid_t, gid_t)>("fchown");
    return Strikes(&Faults::owning) ? -1 : real(file, user, group);
  }

  int flock(int file, int operation)
  {
    static const auto real = Real<int(int, int)>("flock");
    return Strikes(&Faults::owning) ? -1 : real(file, operation);
  }

  int stat(const char* path, struct stat* state)
  {
    static const auto real = Real<int(const char*, struct stat*)>("stat");
    Await(path);
    return Strikes(&Faults::looking) ? -1 : real(path, state);
  }

  int lstat(const char* path, struct stat* state)
  {
    static const auto real = Real<int(const char*, struct stat*)>("lstat");
    Await(path);
    return Strikes(&Faults::looking) ? -1 : real(path, state);
  }

  int fstat(int file, struct stat* state)
  {
    static const auto real = Real<int(int, struct stat*)>("fstat");
    Await(file);
    return Strikes(&Faults::looking) ? -1 : real(file, state);
  }

  int stat64(const char* path, struct stat64* state)
  {
    static const auto real = Real<int(const char*, struct stat64*)>("stat64");
    return Strikes(&Faults::looking) ? -1 : real(path, state);
  }

  int lstat64(const char* path, struct stat64* state)
  {
    static const auto real = Real<int(const char*, struct stat64*)>("lstat64");
    return Strikes(&Faults::looking) ? -1 : real(path, state);
  }

  int fstat64(int file, struct stat64* state)
  {
    static const auto real = Real<int(int, struct stat64*)>("fstat64");
    return Strikes(&Faults::looking) ? -1 : real(file, state);
  }

  void* mmap(void* place, std::size_t bytes, int protection, int flags, int file, off_t offset)
  {
    return faults && Strikes(&Faults::mapping) ? MAP_FAILED
                                               : reinterpret_cast<void*>(::syscall(SYS_mmap, place,
                                                   bytes, protection, flags, file, offset));
  }

  void* mmap64(void* place, std::size_t bytes, int protection, int flags, int file, off64_t offset)
  {
    return mmap(place, bytes, protection, flags, file, offset);
  }

  int pthread_create(
    pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*), void* argument)
  {
    static const auto real =
      Real<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
    return Strikes(&Faults::starting) ? errno : real(thread, attributes, work, argument);
  }

  int accept4(int listener, sockaddr* address, socklen_t* length, int flags)
  {
    static const auto real = Real<int(int, sockaddr*, socklen_t*, int)>("accept4");
    return Strikes(&Faults::accepting) ? -1 : real(listener, address, length, flags);
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

  void* memalign(std::size_t alignment, std::size_t bytes)
  {
    return FailsToAllocate(bytes) ? nullptr : __libc_memalign(alignment, bytes);
  }

  void* aligned_alloc(std::size_t alignment, std::size_t bytes)
  {
    return memalign(alignment, bytes);
  }

  int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes)
  {
    void* const got = memalign(alignment, bytes);
    if (!got)
    {
      return ENOMEM;
    }
    *memory = got;
    return 0;
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
    return Strikes(&Faults::tls) ? nullptr : real(context);
  }
}
