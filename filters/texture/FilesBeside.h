// SPDX-License-Identifier: BSD-3-Clause
// Finds the files that a mesh names: pictures and material libraries, whose names may be written by
// other programs and other systems. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/texture/TexturedMesh.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// The path of a file that `base` names: relative to base's folder. If the name is absolute, or
// leads out of that folder, as names from other machines do (C:\scans\a.png, ../../a.png), only its
// last part is used, in the folder itself. So a mesh reads no file outside its folder, except
// through links in it. Backslashes are slashes.
std::filesystem::path FileBeside(const std::filesystem::path& base, std::string_view written);

// Whether a name is of this kind.
bool LeadsOutside(std::string_view written);

// The end of a sentence on a file that is not found: "is not there"; or where it lies, if the name
// leads outside the folder or into the web. isPlural: "are not there".
std::string WhyMissing(std::string_view written, bool isPlural = false);

// The picture that a mesh names, whose file was found or is where it should be. Its name has
// `before` and `after` around the file's, or around the whole name where that leads outside.
PictureSource PictureBeside(const std::filesystem::path& file, std::string_view written,
  const std::string& before, const std::string& after);

// Blanks around names of files and materials in statements.
inline constexpr std::string_view blanksOfNames = " \t\r";

// A name without blanks around it, and without quotes around that.
std::string_view WithoutQuotes(std::string_view name);

// A name up to a comment, " # …"; all of it where there is none.
std::string_view WithoutComment(std::string_view name);

// Letters made small, and one character with their combining marks (macOS writes two); backslashes
// made slashes, and a blank for several.
std::string FoldedName(std::string_view name);

class FilesBeside
{
public:
  explicit FilesBeside(std::filesystem::path base)
    : Base(std::move(base))
  {
  }

  // The file that `written` means, or the path where it should be if there is none. The first of
  // these that exists: the name as it is written; without quotes; up to a comment; percent-decoded
  // (%20); with bytes that are not UTF-8 taken for Windows' Latin letters; in upper or lower case,
  // if only one file fits; the same for its last part, in base's folder. The names of a folder are
  // read once, at most the first 65,536. Time: O(log n) of them.
  std::filesystem::path Find(std::string_view written);
  const std::filesystem::path& MeshFile() const { return this->Base; }

private:
  // By folded name; none where several names fold to it.
  using Names = std::map<std::string, std::optional<std::string>, std::less<>>;

  const Names& NamesOf(const std::filesystem::path& folder);
  std::optional<std::filesystem::path> FindFolded(const std::filesystem::path& relative);

  std::filesystem::path Base;
  std::map<std::filesystem::path, Names> Folders;
};

}
