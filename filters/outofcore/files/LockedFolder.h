// SPDX-License-Identifier: BSD-3-Clause
// Folders for temporary files. A folder that a killed process left behind is recognized and removed
// by the next process that makes a folder in the same place.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// A hidden folder of this process. Its name is ".kdstream-files-", the process's machine and
// number, and random letters.
struct LockedFolder
{
  std::filesystem::path path;
  std::shared_ptr<void> lock; // held by the owner; the system releases it when the process ends
};

// Makes a new folder in `parent`, accessible only to this user. Errors: InputOutput.
Result<LockedFolder> MakeLockedFolder(const std::filesystem::path& parent);

// Removes the folders in `parent` that belong to this user and whose process has ended. On a local
// disk the lock shows that it has ended. Other file systems may not support locks, or only between
// processes of one machine. There either the process must have run on this machine and be gone, or
// nothing in the folder has changed for a day. Folders that cannot be removed stay.
void RemoveDeadFolders(const std::filesystem::path& parent);

}
