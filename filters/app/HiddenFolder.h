// SPDX-License-Identifier: BSD-3-Clause
// A folder of an export that appears as a whole or not at all.
#pragma once

#include "filters/core/Result.h"
#include "filters/outofcore/files/LockedFolder.h"

#include <filesystem>

namespace kdstream
{

// Its files are written into a hidden folder, which is removed at the end. If the process is
// killed, the next one removes it (RemoveDeadFolders).
class HiddenFolder
{
public:
  HiddenFolder() = default;
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;
  ~HiddenFolder();

  // Makes the hidden folder in `parent`. Errors: InputOutput.
  Status Make(const std::filesystem::path& parent, const std::filesystem::path& name);
  // The folder to write files into. REQUIRES: Make.
  const std::filesystem::path& Place() const { return this->Files; }
  // Renames the folder to `as`, once all its content is on the disk. Errors: InputOutput; then it
  // stays hidden.
  Status Appear(const std::filesystem::path& as) const;

private:
  LockedFolder Hidden;
  std::filesystem::path Files;
};

}
