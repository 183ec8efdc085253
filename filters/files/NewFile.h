// SPDX-License-Identifier: BSD-3-Clause
// A file while it is written: under a random name of its own beside its target, whose place it
// takes when it is whole. The one way in which this project writes files whole.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string_view>

namespace kdstream
{

// A file appears whole or not at all: one that is destroyed before Finish is removed. Nobody else's
// file is opened or cut off on the way, whatever names and links others have put beside the target
// (O_EXCL, O_NOFOLLOW, random letters).
//
// A new file has the permissions that the umask gives to new files. One that replaces another takes
// over that one's owner, group and permissions: whoever has made it private finds it private
// afterwards. Until then nobody can read the new one who may not read the old one. A symbolic link
// is replaced itself; what it leads to stays as it is, and tells only how private the new file is.
// (Programs follow the links that users name before they come here: CheckOutput.)
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

  // What it is to become.
  const std::filesystem::path& Target() const { return this->Place; }
  // What it is called now.
  const std::filesystem::path& Path() const { return this->Temporary; }
  // The folder of both.
  std::filesystem::path Folder() const;
  // Open for reading and writing, as long as this is.
  int Descriptor() const { return this->File; }

  // Appends bytes. Errors: InputOutput.
  Status Write(std::string_view bytes);

  // After something could not be written: the errno of a disk on which nothing more has room, or 0.
  // Tries it, at the end of the file, which is then of no use.
  int WhyFull() const;

  enum class Lasts
  {
    PowerCuts, // file and folder wait for the disk
    Processes  // a temporary file
  };
  // Puts the file in its target's place. Errors: InputOutput; then the target is as it was, unless
  // the message says that it is in place.
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
