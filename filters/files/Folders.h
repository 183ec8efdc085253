// SPDX-License-Identifier: BSD-3-Clause
// Folders: only for one user, and made to outlast a power cut with all that is in them; a file
// without a name in one. By the
// system's own calls: the iterators of std::filesystem end the process where memory runs out.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Makes the folder only for its owner, and those that it is in as the umask has it. One that is
// there stays as it is: its permissions are somebody's decision. Errors: InputOutput.
Status MakePrivateFolder(const std::filesystem::path& folder);

// Waits until the disk has the folder's entries. A folder that this user may not read is passed
// over. Errors: InputOutput.
Status SyncFolder(const std::filesystem::path& folder);

// Waits until the disk has all files and folders below this one, and itself. Links are not
// followed. Errors: InputOutput.
Status SyncTree(const std::filesystem::path& folder);

// What is in a folder, in no order. Errors: InputOutput.
Result<std::vector<std::string>> NamesIn(const std::filesystem::path& folder);

// Opens a file in the folder that has no name: nobody else can open it, and it ends with its
// descriptor, which the caller closes. -1: errno says why not.
int OpenNameless(const std::filesystem::path& folder);

// Removes the folder and all below it, as far as that can be done. For destructors: does not throw
// where memory runs out, and tries again.
void RemoveTree(const std::filesystem::path& folder) noexcept;

}
