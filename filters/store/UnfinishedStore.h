// SPDX-License-Identifier: BSD-3-Clause
// The file of a store while it is written: under a name of its own beside the store, whose place it
// takes when it is whole. For those that write stores alone.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>

namespace kdstream
{

// A store appears whole or not at all: one that is destroyed before Finish removes its file. A new
// store has the permissions that the umask gives to new files. One that replaces another takes over
// that one's: whoever has made a store private finds it private after the next build. Until then
// nobody can read the file who may not read the store.
class UnfinishedStore
{
public:
  // Also removes what writers of this store that were killed have left. Errors: InputOutput.
  static Result<UnfinishedStore> Create(const std::filesystem::path& store);

  UnfinishedStore(UnfinishedStore&& other) noexcept;
  UnfinishedStore& operator=(UnfinishedStore&&) = delete;
  ~UnfinishedStore();

  // What it is to become.
  const std::filesystem::path& Store() const { return this->Target; }
  const std::filesystem::path& Path() const { return this->Temporary; }
  // The folder of both.
  std::filesystem::path Folder() const;
  // Open for reading and writing, as long as this is.
  int Descriptor() const { return this->File; }

  // After something could not be written: the errno of a disk on which nothing more has room, or 0.
  // Tries it, at the end of the file, which is then of no use.
  int WhyFull() const;

  // Makes the file durable and puts it in the store's place. Errors: InputOutput.
  Status Finish();

private:
  explicit UnfinishedStore(std::filesystem::path store)
    : Target(std::move(store))
  {
  }
  Status MakeFile();

  std::filesystem::path Target, Temporary;
  int File = -1; // locked, as long as this process writes it
};

}
