// SPDX-License-Identifier: BSD-3-Clause
// Folders for temporary files that are recognized as left over after a process was killed: the next
// process that makes such a folder beside them removes them.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// A hidden folder of this process: ".kdstream-files-", the process's machine and number, and random
// letters.
struct LockedFolder
{
  std::filesystem::path path;
  std::shared_ptr<void> lock; // kept by the owner; the system releases it when the process ends
};

// Makes a new one in `parent`, only for this user. Errors: InputOutput.
Result<LockedFolder> MakeLockedFolder(const std::filesystem::path& parent);

// Removes the folders in `parent` that belong to this user and whose process has ended. On a local
// disk the lock shows this. Other file systems may not lock, or only between processes of one
// machine; there the process must have run on this machine and be gone, or nothing in the folder
// has changed for a day. What cannot be removed stays.
void RemoveDeadFolders(const std::filesystem::path& parent);

}
