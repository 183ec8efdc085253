// SPDX-License-Identifier: BSD-3-Clause
// A folder that is held open: operations happen in this folder, even if others rename or replace
// the folders of its path. For folders below a folder to which other users may write.
#pragma once

#include "filters/core/Result.h"

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace kdstream
{

// Holds a folder by its descriptor, until the object is destroyed. Threads: as an int.
class HeldFolder
{
public:
  // A folder that a user names: links on the way to it are followed. Errors: InputOutput.
  static Result<HeldFolder> Open(const std::filesystem::path& folder);

  // The folder `name` in this one. If it does not exist, it is made with these permissions (less
  // the umask), and `made` is set to true. Errors: InputOutput, also if it is a link: links are not
  // followed.
  Result<HeldFolder> Below(const std::string& name, mode_t mode, bool* made = nullptr) const;
  // The same for a folder that must be private: its owner is this user or root, and nobody else may
  // write to it. If this user owns it, write permissions of others are removed. Errors:
  // InputOutput, also if another user owns it; then the folder is not changed.
  Result<HeldFolder> OwnBelow(const std::string& name) const;

  // Whether `name` is a regular file that this user or root owns and that has no other name. False
  // if it does not exist. Errors: InputOutput for anything else; nothing is changed.
  Result<bool> HasOwnFile(const std::string& name) const;

  // The folder's path as the user gave it, for messages.
  const std::filesystem::path& Name() const { return this->Called; }
  // A path that leads to the folder as long as it is held, even in other processes of this user.
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
