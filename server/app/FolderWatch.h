// SPDX-License-Identifier: BSD-3-Clause
// Tells when stores of a folder have come, changed or gone (inotify).
#pragma once

#include "filters/core/Result.h"

#include <filesystem>

namespace kdstream
{

class FolderWatch
{
public:
  // Errors: InputOutput where the system watches no more folders, or not this one.
  static Result<FolderWatch> Open(const std::filesystem::path& folder);
  ~FolderWatch();
  FolderWatch(FolderWatch&& other) noexcept;
  FolderWatch& operator=(FolderWatch&&) = delete;

  // Becomes readable when something has happened.
  int Descriptor() const { return this->File; }

  // Whether, since it was asked last, a NAME.kds has been closed by who wrote it, has got its name,
  // or has lost it.
  bool HasChanged();

private:
  explicit FolderWatch(int file)
    : File(file)
  {
  }
  int File;
};

}
