// SPDX-License-Identifier: BSD-3-Clause
// Makes folders that are private to one user, and folders whose content outlasts a power cut; opens
// files without a name. Uses system calls, because the iterators of std::filesystem end the process
// when memory runs out.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Makes a folder that only its owner can access; missing parent folders get permissions by the
// umask. An existing folder keeps its permissions, which somebody may have chosen. Errors:
// InputOutput.
Status MakePrivateFolder(const std::filesystem::path& folder);

// Waits until the disk has the folder's entries. Skips a folder that this user may not read.
// Errors: InputOutput.
Status SyncFolder(const std::filesystem::path& folder);

// Waits until the disk has all files and folders below this one, and the folder itself. Links are
// not followed. Errors: InputOutput.
Status SyncTree(const std::filesystem::path& folder);

// The names in a folder, in no particular order. Errors: InputOutput.
Result<std::vector<std::string>> NamesIn(const std::filesystem::path& folder);

// Opens a file without a name in the folder: nobody else can open it, and it disappears when the
// caller closes the descriptor. Returns -1 on failure, with errno set.
int OpenNameless(const std::filesystem::path& folder);

// Removes the folder and everything below it, as far as possible. For destructors: when memory runs
// out, it does not throw, but tries again.
void RemoveTree(const std::filesystem::path& folder) noexcept;

}
