// SPDX-License-Identifier: BSD-3-Clause
// A file while it is written. It has a random name beside its target, and replaces the target when
// it is complete. All files that this project writes as a whole are written in this way.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string_view>

namespace kdstream
{

// Writes all of these bytes to an open file, if necessary in several parts. Errors: InputOutput.
Status WriteAll(int descriptor, std::string_view bytes);

// A file appears whole or not at all: if the object is destroyed before Finish, the file is
// removed. No other file is opened or truncated, whatever files and links other users have put
// beside the target (O_EXCL, O_NOFOLLOW, random letters).
//
// The umask decides the permissions of a new file. A file that replaces another gets the owner,
// group and permissions of the old one: a private file stays private. Before Finish only those who
// may read the old file can read the new one. A symbolic link is itself replaced; the file to which
// it leads does not change, and only decides the permissions of the new file. (Programs resolve
// links that users name before they call this: CheckOutput.)
class NewFile
{
public:
  // Errors: InputOutput, also if the target exists and is not a regular file.
  static Result<NewFile> Create(const std::filesystem::path& target);

  // Removes the temporary files that killed writers of this target have left. Reads the folder.
  static void RemoveLeftovers(const std::filesystem::path& target);

  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&& other) noexcept;
  ~NewFile();

  // The path that the file has after Finish.
  const std::filesystem::path& Target() const { return this->Place; }
  // The path of the temporary file.
  const std::filesystem::path& Path() const { return this->Temporary; }
  // The folder that contains both.
  std::filesystem::path Folder() const;
  // A descriptor for reading and writing, open as long as this object exists.
  int Descriptor() const { return this->File; }

  // Appends bytes. Errors: InputOutput.
  Status Write(std::string_view bytes);

  // Call this after a failed write: returns the errno of a full disk or quota, or 0. It tries to
  // write at the end of the file, so the file must not be used afterwards.
  int WhyFull() const;

  enum class Lasts
  {
    PowerCuts, // waits until the disk has the file and its name
    Processes  // does not wait: for temporary files
  };
  // Puts the file in its target's place. lasts: what the file must outlast. Errors: InputOutput;
  // the target is then unchanged, unless the message says that the file is in place.
  Status Finish(Lasts lasts = Lasts::PowerCuts);

private:
  explicit NewFile(std::filesystem::path target)
    : Place(std::move(target))
  {
  }
  Status Make();
  void Discard();

  std::filesystem::path Place, Temporary;
  int File = -1;       // locked while this process writes it
  int FolderFile = -1; // for fsync; -1 if the folder cannot be read
};

}
