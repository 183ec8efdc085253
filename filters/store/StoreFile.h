// SPDX-License-Identifier: BSD-3-Clause
// The file of an open store, and the check that it is unchanged. Only for filters/store.
#pragma once

#include "filters/core/Result.h"

#include <sys/stat.h>

#include <filesystem>
#include <memory>

namespace kdstream
{

// The state of a file, which is known without reading the content.
struct FileState
{
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  timespec modified = {}; // time of the last change of the content; a writer can set it back
  timespec changed = {};  // last change of content, name, permissions …; cannot be set back

  // Whether it is the same file, of the same size, last written at the same time.
  bool SameContent(const FileState& other) const;
  // Whether the file was not touched at all.
  bool operator==(const FileState& other) const;

  // The state of the file at a path; all zero if there is none.
  static FileState Of(const std::filesystem::path& file);
};

// One descriptor of a file: the file stays readable even if it is renamed or removed, or if another
// file takes its name. Any number of threads may use it at the same time.
class StoreFile
{
public:
  // Opens a file that nobody is changing. Waits until its last change is older than the resolution
  // of the file system's clock (20 ms), so that a later change shows in the file's state. Errors:
  // NotFound if there is no such file; InputOutput if it cannot be opened or keeps changing.
  static Result<std::unique_ptr<const StoreFile>> Open(const std::filesystem::path& file);
  ~StoreFile();
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  int Descriptor() const { return this->Handle; }
  // Errors: InputOutput.
  Result<FileState> State() const;
  // The state as far as the kernel knows it: does not wait for a disk or another machine.
  Result<FileState> KnownState() const;

private:
  explicit StoreFile(int descriptor)
    : Handle(descriptor)
  {
  }
  int Handle;
};

}
