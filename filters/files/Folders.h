// SPDX-License-Identifier: BSD-3-Clause
// Makes folders that are private to one user, and folders whose content outlasts a power cut; opens
// a file without a name. Uses the system's own calls, because the iterators of std::filesystem end
// the process when memory runs out.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Makes the folder for its owner only, and missing parent folders by the umask. An existing folder
// keeps its permissions, which somebody may have chosen. Errors: InputOutput.
Status MakePrivateFolder(const std::filesystem::path& folder);

// Waits until the disk has the folder's entries. Skips a folder that this user may not read.
// Errors: InputOutput.
Status SyncFolder(const std::filesystem::path& folder);

// Waits until the disk has all files and folders below this one, and the folder itself. Links are
// not followed. Errors: InputOutput.
Status SyncTree(const std::filesystem::path& folder);

// What is in a folder, in no order. Errors: InputOutput.
Result<std::vector<std::string>> NamesIn(const std::filesystem::path& folder);

// Opens a file without a name in the folder: nobody else can open it, and it disappears when the
// caller closes the descriptor. -1: see errno.
int OpenNameless(const std::filesystem::path& folder);

// Removes the folder and everything below it, as far as possible. For destructors: does not throw
// when memory runs out, but tries again.
void RemoveTree(const std::filesystem::path& folder) noexcept;

}
