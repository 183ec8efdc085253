// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/DescriptorVfs.h"

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace kdstream
{
namespace
{

struct DescriptorFile
{
  sqlite3_file base;
  int descriptor;
};

int DescriptorOf(sqlite3_file* file)
{
  return reinterpret_cast<DescriptorFile*>(file)->descriptor;
}

int Close(sqlite3_file*)
{
  return SQLITE_OK;
}

int Read(sqlite3_file* file, void* data, int bytes, sqlite3_int64 offset)
{
  auto* to = static_cast<char*>(data);
  while (bytes > 0)
  {
    const ssize_t got = ::pread(DescriptorOf(file), to, static_cast<std::size_t>(bytes), offset);
    if (got < 0 && errno == EINTR)
    {
      continue;
    }
    if (got < 0)
    {
      return SQLITE_IOERR_READ;
    }
    if (got == 0)
    {
      std::memset(to, 0, static_cast<std::size_t>(bytes)); // as SQLite requires
      return SQLITE_IOERR_SHORT_READ;
    }
    to += got;
    bytes -= static_cast<int>(got);
    offset += got;
  }
  return SQLITE_OK;
}

int FileSize(sqlite3_file* file, sqlite3_int64* bytes)
{
  struct stat status = {};
  if (::fstat(DescriptorOf(file), &status) != 0)
  {
    return SQLITE_IOERR_FSTAT;
  }
  *bytes = status.st_size;
  return SQLITE_OK;
}

// If the file is open only for reading, the system refuses the write.
int Write(sqlite3_file* file, const void* data, int bytes, sqlite3_int64 offset)
{
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0)
  {
    const ssize_t put = ::pwrite(DescriptorOf(file), from, static_cast<std::size_t>(bytes), offset);
    if (put < 0 && errno == EINTR)
    {
      continue;
    }
    if (put <= 0)
    {
      return put == 0 || errno == ENOSPC ? SQLITE_FULL : SQLITE_IOERR_WRITE;
    }
    from += put;
    bytes -= static_cast<int>(put);
    offset += put;
  }
  return SQLITE_OK;
}

int Truncate(sqlite3_file* file, sqlite3_int64 bytes)
{
  return ::ftruncate(DescriptorOf(file), bytes) == 0 ? SQLITE_OK : SQLITE_IOERR_TRUNCATE;
}

int Sync(sqlite3_file*, int)
{
  return SQLITE_OK;
}

int Lock(sqlite3_file*, int)
{
  return SQLITE_OK;
}

int CheckReservedLock(sqlite3_file*, int* isLocked)
{
  *isLocked = 0;
  return SQLITE_OK;
}

int FileControl(sqlite3_file*, int, void*)
{
  return SQLITE_NOTFOUND;
}

int SectorSize(sqlite3_file*)
{
  return 4096;
}

int DeviceCharacteristics(sqlite3_file*)
{
  return 0; // files that are only read are opened as immutable by their URI
}

constexpr sqlite3_io_methods methods{ 1, Close, Read, Write, Truncate, Sync, FileSize, Lock, Lock,
  CheckReservedLock, FileControl, SectorSize, DeviceCharacteristics, nullptr, nullptr, nullptr,
  nullptr, nullptr, nullptr };

// Opens only the database itself, neither a journal nor a temporary file.
int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* outFlags)
{
  file->pMethods = nullptr;
  if (!(flags & SQLITE_OPEN_MAIN_DB))
  {
    return SQLITE_CANTOPEN;
  }
  const auto descriptor = sqlite3_uri_int64(name, "descriptor", -1);
  if (descriptor < 0)
  {
    return SQLITE_CANTOPEN;
  }
  auto* opened = reinterpret_cast<DescriptorFile*>(file);
  opened->base.pMethods = &methods;
  opened->descriptor = static_cast<int>(descriptor);
  if (outFlags)
  {
    *outFlags = flags;
  }
  return SQLITE_OK;
}

// Tells SQLite that no journal exists.
int Access(sqlite3_vfs*, const char*, int, int* exists)
{
  *exists = 0;
  return SQLITE_OK;
}

int FullPathname(sqlite3_vfs*, const char* name, int bytes, char* full)
{
  const std::size_t length = std::strlen(name) + 1;
  if (length > static_cast<std::size_t>(bytes))
  {
    return SQLITE_CANTOPEN;
  }
  std::memcpy(full, name, length);
  return SQLITE_OK;
}

const char* Register()
{
  static sqlite3_vfs vfs = {};
  sqlite3_vfs* const platform = sqlite3_vfs_find(nullptr);
  if (!platform)
  {
    return nullptr;
  }
  vfs = *platform; // time, sleep and random numbers come from the platform
  vfs.szOsFile = std::max(platform->szOsFile, static_cast<int>(sizeof(DescriptorFile)));
  vfs.pNext = nullptr;
  vfs.zName = "kdstream-descriptor";
  vfs.xOpen = Open;
  vfs.xAccess = Access;
  vfs.xFullPathname = FullPathname;
  return sqlite3_vfs_register(&vfs, 0) == SQLITE_OK ? vfs.zName : nullptr;
}

}

const char* DescriptorVfs()
{
  static const char* const name = Register();
  return name;
}

}
