// SPDX-License-Identifier: BSD-3-Clause
// A folder of an export that appears whole or not at all.
#pragma once

#include "filters/core/Result.h"
#include "filters/outofcore/files/LockedFolder.h"

#include <filesystem>

namespace kdstream
{

// Its files are written into a hidden folder beside it, or in it, which is removed at the end. A
// killed process leaves it to the next one (RemoveDeadFolders).
class HiddenFolder
{
public:
  HiddenFolder() = default;
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;
  ~HiddenFolder();

  // Makes the folder, hidden in `parent`. Errors: InputOutput.
  Status Make(const std::filesystem::path& parent, const std::filesystem::path& name);
  // The folder for its files. REQUIRES: Make.
  const std::filesystem::path& Place() const { return this->Files; }
  // Gives it its name, when the disk has all that is in it. Errors: InputOutput; it stays hidden.
  Status Appear(const std::filesystem::path& as) const;

private:
  LockedFolder Hidden;
  std::filesystem::path Files;
};

}
