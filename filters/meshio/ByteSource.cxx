// SPDX-License-Identifier: BSD-3-Clause
// A file read from front to back in large blocks: the lowest layer of step "read".
#include "filters/meshio/ByteSource.h"

#include "filters/core/SystemReason.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kdstream
{

Result<ByteSource> ByteSource::Open(const std::filesystem::path& file)
{
  // O_NONBLOCK: otherwise opening a named pipe would wait, although it is then refused.
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0)
  {
    const int reason = errno;
    if (reason == ENOENT || reason == ENOTDIR)
    {
      return Error{ ErrorCode::NotFound, "no such file" };
    }
    return Error{ ErrorCode::InputOutput, "cannot be opened: " + SystemReason(reason) };
  }
  ByteSource source(descriptor, 0);
  struct stat status = {};
  if (fstat(descriptor, &status) != 0)
  {
    return Error{ ErrorCode::InputOutput, "cannot be examined: " + SystemReason(errno) };
  }
  if (S_ISDIR(status.st_mode))
  {
    return Error{ ErrorCode::InvalidInput, "is a directory, not a file" };
  }
  if (!S_ISREG(status.st_mode))
  {
    return Error{ ErrorCode::InvalidInput, "is not a regular file" };
  }
  source.FileSize = static_cast<std::uint64_t>(status.st_size);
  // This is only advice: if the system ignores it, reading works as well.
  static_cast<void>(posix_fadvise(descriptor, 0, 0, POSIX_FADV_SEQUENTIAL));
  return source;
}

Result<ByteSource> ByteSource::Again() const
{
  const int descriptor = fcntl(this->Descriptor, F_DUPFD_CLOEXEC, 0);
  if (descriptor < 0)
  {
    return Error{ ErrorCode::InputOutput, "cannot be opened again: " + SystemReason(errno) };
  }
  return ByteSource(descriptor, this->FileSize);
}

ByteSource::ByteSource(int descriptor, std::uint64_t size)
  : Descriptor(descriptor)
  , FileSize(size)
{
}

ByteSource::ByteSource(ByteSource&& other) noexcept
  : Descriptor(std::exchange(other.Descriptor, -1))
  , First(other.First)
  , FileSize(other.FileSize)
  , BufferOffset(other.BufferOffset)
  , Begin(std::exchange(other.Begin, 0))
  , End(std::exchange(other.End, 0))
  , Buffer(std::move(other.Buffer))
{
}

ByteSource::~ByteSource()
{
  if (this->Descriptor >= 0)
  {
    close(this->Descriptor);
  }
}

Result<std::string_view> ByteSource::Peek(std::size_t wanted)
{
  assert(wanted <= blockSize);
  if (this->End - this->Begin < wanted)
  {
    this->Buffer.resize(
      static_cast<std::size_t>(std::min<std::uint64_t>(blockSize, this->FileSize)));
    const std::size_t kept = this->End - this->Begin;
    if (kept > 0)
    {
      std::memmove(this->Buffer.data(), this->Buffer.data() + this->Begin, kept);
    }
    this->BufferOffset += this->Begin;
    this->Begin = 0;
    this->End = kept;
    // Never reads past the size at opening: if the file grows meanwhile, it is read as it was.
    const std::size_t full = static_cast<std::size_t>(
      std::min<std::uint64_t>(this->Buffer.size(), this->FileSize - this->BufferOffset));
    while (this->End < full)
    {
      const std::uint64_t offset = this->BufferOffset + this->End;
      const ssize_t got = pread(this->Descriptor, this->Buffer.data() + this->End, full - this->End,
        static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR)
      {
        continue;
      }
      if (got < 0)
      {
        return Error{ ErrorCode::InputOutput, "cannot be read: " + SystemReason(errno), {},
          "byte " + std::to_string(offset) };
      }
      if (got == 0)
      {
        break;
      }
      this->End += static_cast<std::size_t>(got);
    }
  }
  return std::string_view(this->Buffer.data() + this->Begin, this->End - this->Begin);
}

void ByteSource::Seek(std::uint64_t position)
{
  assert(position <= this->FileSize);
  if (position >= this->BufferOffset && position <= this->BufferOffset + this->End)
  {
    this->Begin = static_cast<std::size_t>(position - this->BufferOffset);
    return;
  }
  this->BufferOffset = position;
  this->Begin = 0;
  this->End = 0;
}

void ByteSource::Crop(std::uint64_t begin, std::uint64_t end)
{
  assert(begin >= this->First && begin <= end && end <= this->FileSize);
  this->First = begin;
  this->FileSize = end;
  this->BufferOffset = begin; // data in memory may lie after the end
  this->Begin = 0;
  this->End = 0;
}

}
