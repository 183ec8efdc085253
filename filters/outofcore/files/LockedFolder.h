// SPDX-License-Identifier: BSD-3-Clause
// Folders for temporary files that are recognised after a process was killed: the next one that
// makes such a folder beside them removes them.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// A hidden folder of this process: ".kdstream-files-", the process' place and number, and random
// letters.
struct LockedFolder
{
  std::filesystem::path path;
  std::shared_ptr<void> lock; // kept by the owner; the system gives it back with the process
};

// Makes a new one in `parent`, only for this user. Errors: InputOutput.
Result<LockedFolder> MakeLockedFolder(const std::filesystem::path& parent);

// Removes those in `parent` that are this user's and whose process has ended. On a disk of this
// machine the lock tells that. On others, which may not lock, or only between the processes of one
// machine, the process must have been one of this machine and be gone, or nothing in the folder
// has been changed for a day. What cannot be removed stays.
void RemoveDeadFolders(const std::filesystem::path& parent);

}
