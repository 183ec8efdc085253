// SPDX-License-Identifier: BSD-3-Clause
#include "filters/files/WriteWhole.h"

#include "filters/core/SystemReason.h"
#include "filters/files/NewFile.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

Status WriteNewFile(const std::filesystem::path& file, std::string_view bytes)
{
  auto output = NewFile::Create(file);
  KDSTREAM_TRY(output);
  KDSTREAM_TRY(output->Write(bytes));
  return output->Finish();
}

}

Status WriteWhole(const std::filesystem::path& file, std::string_view bytes)
{
  return OfFile(file.string(), WriteNewFile(file, bytes));
}

Status WriteToOutput(const std::filesystem::path& file, std::string_view bytes)
{
  struct stat found = {};
  const bool isThere = ::stat(file.c_str(), &found) == 0;
  if (!NamesDescriptor(file) && (!isThere || S_ISREG(found.st_mode)))
  {
    return WriteNewFile(file, bytes);
  }
  // Does not truncate or create: appends to the output to which a shell has redirected.
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0)
  {
    return SystemError("cannot be written", errno);
  }
  const Status written = WriteAll(descriptor, bytes);
  ::close(descriptor);
  return written;
}

Status WriteAnew(const std::filesystem::path& file, std::string_view bytes)
{
  const int descriptor =
    ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0)
  {
    return SystemError("cannot be written", errno, file.string());
  }
  const Status written = WriteAll(descriptor, bytes);
  ::close(descriptor);
  return OfFile(file.string(), written);
}

bool NamesDescriptor(const std::filesystem::path& file)
{
  const std::string name = file.lexically_normal().string();
  return name == "/dev/stdout" || name == "/dev/stderr" || name.starts_with("/dev/fd/") ||
         name.starts_with("/proc/self/fd/");
}

bool HasBytes(const std::filesystem::path& file, std::string_view bytes)
{
  const int descriptor =
    ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | O_NOFOLLOW);
  struct stat found = {};
  bool same = descriptor >= 0 && ::fstat(descriptor, &found) == 0 && S_ISREG(found.st_mode) &&
              static_cast<std::uint64_t>(found.st_size) == bytes.size();
  std::vector<char> block(std::min<std::size_t>(bytes.size(), std::size_t{ 1 } << 16));
  while (same && !bytes.empty())
  {
    const ssize_t got = ::read(descriptor, block.data(), std::min(block.size(), bytes.size()));
    if (got < 0 && errno == EINTR)
    {
      continue;
    }
    const auto some = static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    same = some > 0 && bytes.substr(0, some) == std::string_view(block.data(), some);
    bytes.remove_prefix(some);
  }
  if (descriptor >= 0)
  {
    ::close(descriptor);
  }
  return same;
}

Result<std::string> ReadWholeFile(
  const std::filesystem::path& file, Links links, std::size_t mostBytes)
{
  const int descriptor = ::open(file.c_str(),
    O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | (links == Links::Refuse ? O_NOFOLLOW : 0));
  if (descriptor < 0)
  {
    const int reason = errno;
    if (reason == ELOOP && links == Links::Refuse)
    {
      return Error{ ErrorCode::InputOutput, "is a symbolic link, which is not followed",
        file.string() };
    }
    return reason == ENOENT || reason == ENOTDIR
             ? Error{ ErrorCode::NotFound, "no such file", file.string() }
             : SystemError("cannot be read", reason, file.string());
  }
  const auto close = [](const int* opened) { ::close(*opened); };
  const std::unique_ptr<const int, decltype(close)> closed(&descriptor, close);
  std::string bytes;
  constexpr std::size_t some = std::size_t{ 1 } << 16;
  for (ssize_t got = 1; got != 0;)
  {
    const std::size_t before = bytes.size();
    bytes.resize(before + some);
    got = ::read(descriptor, bytes.data() + before, some);
    if (got < 0 && errno != EINTR)
    {
      return SystemError("cannot be read", errno, file.string());
    }
    bytes.resize(before + (got < 0 ? 0 : static_cast<std::size_t>(got)));
    if (bytes.size() > mostBytes)
    {
      return Error{ ErrorCode::LimitExceeded,
        "has more than " + std::to_string(mostBytes) + " bytes, which is too much for its purpose",
        file.string() };
    }
  }
  return bytes;
}

}
