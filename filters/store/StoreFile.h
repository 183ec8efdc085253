// SPDX-License-Identifier: BSD-3-Clause
// The file of an open store, and whether it is still what it was. Only for filters/store.
#pragma once

#include "filters/core/Result.h"

#include <sys/stat.h>

#include <filesystem>
#include <memory>

namespace kdstream
{

// What a file says of its content without being read.
struct FileState
{
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  timespec modified = {}; // of the content; a writer can set this time back
  timespec changed = {};  // of the content, the name, the permissions …; cannot be set back

  // The same file, with as much in it, last written at the same time.
  bool SameContent(const FileState& other) const;
  // Equal: the file was not touched at all.
  bool operator==(const FileState& other) const;

  // The state of the file at a path; all zero if there is none.
  static FileState Of(const std::filesystem::path& file);
};

// One descriptor of a file: the file stays readable even if it is renamed or removed, or another
// file takes its name. Threads: all may use it at once.
class StoreFile
{
public:
  // Opens a file that nobody is changing. Waits until its last change is older than the resolution
  // of the file system's clock (20 ms), so that a later change shows in its state. Errors: NotFound
  // if there is no such file; InputOutput if it cannot be opened, or keeps changing.
  static Result<std::unique_ptr<const StoreFile>> Open(const std::filesystem::path& file);
  ~StoreFile();
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;

  int Descriptor() const { return this->Handle; }
  // Errors: InputOutput.
  Result<FileState> State() const;
  // As far as the kernel knows it: waits for no disk and no other machine.
  Result<FileState> KnownState() const;

private:
  explicit StoreFile(int descriptor)
    : Handle(descriptor)
  {
  }
  int Handle;
};

}
