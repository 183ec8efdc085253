// SPDX-License-Identifier: BSD-3-Clause
// A file opened for reading, which the destructor closes. Internal: not installed.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

namespace kdstream
{

struct OpenFile
{
  int descriptor = -1; // -1: errno says why it is not open
  // flags: further flags of open(2).
  explicit OpenFile(const std::filesystem::path& path, int flags = 0)
    : descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags))
  {
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile()
  {
    if (this->descriptor >= 0)
    {
      ::close(this->descriptor);
    }
  }
};

}
