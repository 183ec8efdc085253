// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/HiddenFolder.h"

#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"

#include <sys/stat.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace kdstream
{

HiddenFolder::~HiddenFolder()
{
  if (!this->Hidden.path.empty())
  {
    RemoveTree(this->Hidden.path);
  }
}

Status HiddenFolder::Make(const std::filesystem::path& parent, const std::filesystem::path& name)
{
  Result<LockedFolder> hidden = MakeLockedFolder(parent);
  KDSTREAM_TRY(hidden);
  this->Hidden = std::move(*hidden);
  this->Files = this->Hidden.path / name;
  return ::mkdir(this->Files.c_str(), 0777) == 0 // the umask still applies
           ? Status{}
           : Status{ SystemError("cannot be written", errno) };
}

Status HiddenFolder::Appear(const std::filesystem::path& as) const
{
  KDSTREAM_TRY(SyncTree(this->Files));
  std::error_code failure;
  std::filesystem::rename(this->Files, as, failure);
  return failure ? Status{ SystemError("cannot be written", failure.value()) } : Status{};
}

}
