// SPDX-License-Identifier: BSD-3-Clause
// A file that appears whole or not at all: written under a temporary name beside it, then renamed.
// For the writers.
#include "filters/meshio/OutputFile.h"

#include "filters/core/SystemReason.h"

#include <cassert>
#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kdstream
{

OutputFile::~OutputFile()
{
  if (this->Descriptor >= 0)
  {
    close(this->Descriptor);
  }
  if (!this->Temporary.empty())
  {
    unlink(this->Temporary.c_str());
  }
}

void OutputFile::Fail(std::string_view what, int reason)
{
  if (this->FirstError)
  {
    this->FirstError = SystemError(std::string(what), reason);
  }
}

Status OutputFile::Open(const std::filesystem::path& file)
{
  assert(this->Descriptor < 0 && this->Target.empty());
  struct stat existing = {};
  if (stat(file.c_str(), &existing) == 0 && !S_ISREG(existing.st_mode))
  {
    return Error{ ErrorCode::InputOutput, "cannot be written: it is not a regular file" };
  }
  this->Target = file;
  // Not mkstemp: the file shall have the permissions that the umask gives to new files.
  for (unsigned attempt = 0;; ++attempt)
  {
    std::filesystem::path name = file;
    name += ".tmp-" + std::to_string(getpid()) + "-" + std::to_string(attempt);
    this->Descriptor = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (this->Descriptor >= 0)
    {
      this->Temporary = name;
      return {};
    }
    if (errno != EEXIST)
    {
      this->Fail("cannot be written", errno);
      return this->FirstError;
    }
  }
}

void OutputFile::Flush()
{
  std::string_view left = this->Buffer;
  while (!left.empty() && this->FirstError)
  {
    const ssize_t written = write(this->Descriptor, left.data(), left.size());
    if (written >= 0)
    {
      left.remove_prefix(static_cast<std::size_t>(written));
    }
    else if (errno != EINTR)
    {
      this->Fail("cannot be written", errno);
    }
  }
  this->Buffer.clear();
}

Status OutputFile::Finish()
{
  assert(this->Descriptor >= 0);
  this->Flush();
  if (this->FirstError && fsync(this->Descriptor) != 0)
  {
    this->Fail("cannot be written", errno);
  }
  if (close(std::exchange(this->Descriptor, -1)) != 0)
  {
    this->Fail("cannot be written", errno);
  }
  if (this->FirstError && rename(this->Temporary.c_str(), this->Target.c_str()) != 0)
  {
    this->Fail("cannot be renamed", errno);
  }
  KDSTREAM_TRY(this->FirstError);
  this->Temporary.clear();
  // The name becomes durable with its folder. Some file systems cannot do that; the file itself is
  // safe by now.
  const std::filesystem::path parent = this->Target.parent_path();
  const int folder =
    open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0)
  {
    static_cast<void>(fsync(folder));
    close(folder);
  }
  return {};
}

}
