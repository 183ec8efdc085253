// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/TokensFile.h"

#include <sys/stat.h>

#include <utility>

namespace kdstream
{

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
  const auto seen = StampOf(file); // before it is read: what is written meanwhile is a change
  auto keys = ReadTokenKeys(file);
  KDSTREAM_TRY(keys);
  return TokensFile(std::move(file), seen, std::move(*keys));
}

Status TokensFile::Look()
{
  if (StampOf(this->File) == this->Seen)
  {
    return {};
  }
  const auto told = this->Told;
  auto status = this->Reload();
  return !status && !told.empty() && this->Told == told ? Status{} : status;
}

Status TokensFile::Reload()
{
  this->Seen = StampOf(this->File);
  this->Told.clear();
  auto keys = ReadTokenKeys(this->File);
  if (!keys && keys.GetError().code == ErrorCode::InputOutput)
  {
    this->Seen = {}; // what stands there now has not been seen
    this->Told = keys.GetError().message;
  }
  KDSTREAM_TRY(keys);
  this->Keeper->Replace(std::move(*keys));
  return {};
}

}
