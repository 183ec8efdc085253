// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/TokensFile.h"

#include "filters/core/CaughtError.h"
#include "filters/core/SystemReason.h"

#include <sys/stat.h>

#include <utility>

namespace kdstream
{

namespace
{

Result<TokenKeys> Caught(const std::filesystem::path& file)
{
  try
  {
    return ReadTokenKeys(file);
  }
  catch (...)
  {
    return CaughtError();
  }
}

}

TokensFile::Stamp TokensFile::StampOf(const std::filesystem::path& file)
{
  struct stat found
  {
  };
  if (::stat(file.c_str(), &found) != 0)
  {
    return {};
  }
  const auto nanoseconds = [](const timespec& time)
  {
    return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000u +
           static_cast<std::uint64_t>(time.tv_nsec);
  };
  return { found.st_mode, found.st_dev, found.st_ino, static_cast<std::uint64_t>(found.st_size),
    nanoseconds(found.st_mtim), nanoseconds(found.st_ctim) };
}

TokensFile::TokensFile(std::filesystem::path file, Stamp seen, TokenKeys keys)
  : File(std::move(file))
  , Seen(seen)
  , Keeper(std::make_shared<TokenGuard>(std::move(keys)))
{
}

Result<TokensFile> TokensFile::Open(std::filesystem::path file)
{
  const auto seen = StampOf(file); // before reading: a write meanwhile counts as a change
  auto keys = ReadTokenKeys(file);
  KDSTREAM_TRY(keys);
  return TokensFile(std::move(file), seen, std::move(*keys));
}

Status TokensFile::Look()
{
  const bool again = this->Again;
  if (!again && StampOf(this->File) == this->Seen)
  {
    return {};
  }
  const auto before = this->Reported;
  auto status = this->Reload();
  return again && this->Again && this->Reported == before ? Status{} : status;
}

Status TokensFile::Reload()
{
  this->Again = true; // if this call fails, try again
  const auto now = StampOf(this->File);
  auto keys = Caught(this->File);
  if (keys)
  {
    this->Keeper->Replace(std::move(*keys));
  }
  this->Seen = now;
  this->Again = !keys && IsTransient(keys.GetError());
  this->Reported = keys ? "" : keys.GetError().message;
  return keys ? Status{} : keys.GetError();
}

}
