// SPDX-License-Identifier: BSD-3-Clause
// Finds the files that a mesh names, pictures and material libraries, even if other programs and
// systems write their names differently. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/texture/TexturedMesh.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// The path of a file that `base` names, relative to base's folder. If the name is absolute, or
// leads out of that folder, as names from other machines do (C:\scans\a.png, ../../a.png), only its
// last part is used, in base's folder. So a mesh reads no file outside its folder, except through
// links in it. Backslashes count as slashes.
std::filesystem::path FileBeside(const std::filesystem::path& base, std::string_view written);

// Whether a name is absolute or leads out of the folder.
bool LeadsOutside(std::string_view written);

// The end of a sentence about a file that is not found: "is not there"; or, if the name leads
// outside the folder or into the web, where it leads. isPlural: "are not there".
std::string WhyMissing(std::string_view written, bool isPlural = false);

// The source of a picture that a mesh names. file: where the picture was found, or should be. Its
// name for messages has `before` and `after` around the file's name, or around the whole written
// name if that leads outside.
PictureSource PictureBeside(const std::filesystem::path& file, std::string_view written,
  const std::string& before, const std::string& after);

// Blanks that are ignored around names of files and materials in statements.
inline constexpr std::string_view blanksOfNames = " \t\r";

// The name without blanks around it, and without quotes around the rest.
std::string_view WithoutQuotes(std::string_view name);

// The name up to a comment, " # …"; the whole name if there is no comment.
std::string_view WithoutComment(std::string_view name);

// The name for comparing: in lower case, with characters and their combining marks as one character
// (macOS writes two), slashes for backslashes, and one blank for several.
std::string FoldedName(std::string_view name);

class FilesBeside
{
public:
  explicit FilesBeside(std::filesystem::path base)
    : Base(std::move(base))
  {
  }

  // The file that `written` means, or the path where it should be if it does not exist. Takes the
  // first of these that exists: the name as written; without quotes; up to a comment;
  // percent-decoded (%20); with bytes that are not UTF-8 read as Windows' Latin letters; in upper
  // or lower case, if only one file fits. Then the same for its last part, in base's folder. The
  // names of a folder are read once, at most the first 65,536. Time: O(log n) for n names.
  std::filesystem::path Find(std::string_view written);
  const std::filesystem::path& MeshFile() const { return this->Base; }

private:
  // File names by folded name; nothing if several names fold to it.
  using Names = std::map<std::string, std::optional<std::string>, std::less<>>;

  const Names& NamesOf(const std::filesystem::path& folder);
  std::optional<std::filesystem::path> FindFolded(const std::filesystem::path& relative);

  std::filesystem::path Base;
  std::map<std::filesystem::path, Names> Folders;
};

}
