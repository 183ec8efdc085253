// SPDX-License-Identifier: BSD-3-Clause
// Reports when stores of a folder were added, changed or removed (inotify), and when another folder
// has taken its name: by a rename, or by a link that now leads elsewhere.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>
#include <utility>

namespace kdstream
{

class FolderWatch
{
public:
  // Errors: InputOutput if the system watches no more folders, or cannot watch this one.
  static Result<FolderWatch> Open(const std::filesystem::path& folder);
  ~FolderWatch();
  FolderWatch(FolderWatch&& other) noexcept;
  FolderWatch& operator=(FolderWatch&&) = delete;

  // Becomes readable when something has happened in the folder.
  int Descriptor() const { return this->File; }

  // Whether one of these has happened since the last call: a writer has closed a file NAME.kds; a
  // file or link was given such a name, or lost it; or the folder has been replaced by another one.
  bool HasChanged();

private:
  using Identity = std::pair<std::uint64_t, std::uint64_t>; // device and inode; 0, 0: none

  FolderWatch(int file, std::filesystem::path folder)
    : File(file)
    , Folder(std::move(folder))
  {
  }
  bool Watch();
  bool TakeEvents();
  bool IsLink(const char* name) const;

  int File;
  std::filesystem::path Folder;
  Identity Watched;
  int Number = -1; // the watch's descriptor
};

}
