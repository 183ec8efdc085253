// SPDX-License-Identifier: BSD-3-Clause
// A folder that is held open: operations happen in this folder, even if others rename or replace
// the folders of its path. For folders below one that others may write to.
#pragma once

#include "filters/core/Result.h"

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace kdstream
{

// Held by its descriptor, until this is destroyed. Threads: as an int.
class HeldFolder
{
public:
  // A folder that a user names: links on the way to it are followed. Errors: InputOutput.
  static Result<HeldFolder> Open(const std::filesystem::path& folder);

  // The folder `name` in this one; if there is none, it is made with these permissions (less the
  // umask), and `made` is set. Errors: InputOutput, also for a link, which is not followed.
  Result<HeldFolder> Below(const std::string& name, mode_t mode, bool* made = nullptr) const;
  // The same for a folder that must be private: its owner is this user or root, and nobody else may
  // write to it. If it is this user's, the permissions of others to write are removed. Errors:
  // InputOutput, also if it is another user's; that folder is not changed.
  Result<HeldFolder> OwnBelow(const std::string& name) const;

  // Whether `name` is a regular file that this user or root owns and that has no other name. False
  // if it does not exist. Errors: InputOutput for anything else, which is not changed.
  Result<bool> HasOwnFile(const std::string& name) const;

  // How the user calls it: for messages.
  const std::filesystem::path& Name() const { return this->Called; }
  // Leads to it as long as this is held, in other processes of this user too.
  std::filesystem::path Path() const;

  HeldFolder(HeldFolder&& other) noexcept;
  HeldFolder& operator=(HeldFolder&& other) noexcept;
  ~HeldFolder();

private:
  HeldFolder(int descriptor, std::filesystem::path name);
  Error NotOwn(const std::string& name) const;

  int Descriptor = -1;
  std::filesystem::path Called;
};

}
