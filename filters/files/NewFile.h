// SPDX-License-Identifier: BSD-3-Clause
// A file while it is written: under a random name beside its target, which it replaces when it is
// complete. All files that this project writes whole are written so.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string_view>

namespace kdstream
{

// Writes all of these bytes to an open file, also in several parts. Errors: InputOutput.
Status WriteAll(int descriptor, std::string_view bytes);

// A file appears whole or not at all: if the object is destroyed before Finish, the file is
// removed. No other file is opened or truncated, whatever files and links others have put beside
// the target (O_EXCL, O_NOFOLLOW, random letters).
//
// A new file gets its permissions by the umask. A file that replaces another gets the owner, group
// and permissions of the old one: a private file stays private. Before Finish only those who may
// read the old file can read the new one. A symbolic link is replaced itself. Its target stays as
// it is, and only decides the permissions of the new file. (Programs resolve links that users name
// before they call this: CheckOutput.)
class NewFile
{
public:
  // Errors: InputOutput, also where the target is there and is not a regular file.
  static Result<NewFile> Create(const std::filesystem::path& target);

  // Removes what writers of this target that were killed have left. Reads the folder.
  static void RemoveLeftovers(const std::filesystem::path& target);

  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&& other) noexcept;
  ~NewFile();

  // The path that the file gets in the end.
  const std::filesystem::path& Target() const { return this->Place; }
  // The path of the temporary file.
  const std::filesystem::path& Path() const { return this->Temporary; }
  // The folder of both.
  std::filesystem::path Folder() const;
  // Open for reading and writing, as long as this is.
  int Descriptor() const { return this->File; }

  // Appends bytes. Errors: InputOutput.
  Status Write(std::string_view bytes);

  // Call this after a failed write: returns the errno of a full disk or quota, or 0. It tries to
  // write at the end of the file, which must not be used afterwards.
  int WhyFull() const;

  enum class Lasts
  {
    PowerCuts, // file and folder wait for the disk
    Processes  // a temporary file
  };
  // Puts the file in its target's place. Errors: InputOutput; the target is then unchanged, unless
  // the message says that the file is in place.
  Status Finish(Lasts lasts = Lasts::PowerCuts);

private:
  explicit NewFile(std::filesystem::path target)
    : Place(std::move(target))
  {
  }
  Status Make();
  void Discard();

  std::filesystem::path Place, Temporary;
  int File = -1;       // locked, as long as this process writes it
  int FolderFile = -1; // for fsync; -1: the folder cannot be read
};

}
