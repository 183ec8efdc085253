// SPDX-License-Identifier: BSD-3-Clause
// The files that a mesh names: pictures and libraries of materials, as other programs and other
// systems write their names. Part of step "read" of the pipeline picture.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// Where a file that `base` names is: relative to base's folder. What is written absolute, or leads
// out of that folder, as other machines write it (C:\scans\a.png, ../../a.png), is looked for by
// its last part, in the folder itself. So a mesh reads no file outside its folder, but through
// links that lie in it. Backslashes are slashes.
std::filesystem::path FileBeside(const std::filesystem::path& base, std::string_view written);

// What lies around names of files and materials, where a statement has them.
inline constexpr std::string_view blanksOfNames = " \t\r";

// A name without blanks around it, and without quotes around that.
std::string_view WithoutQuotes(std::string_view name);

// A name up to a comment, " # …"; all of it where there is none.
std::string_view WithoutComment(std::string_view name);

// Letters of ASCII made small, backslashes slashes, and a blank for several.
std::string FoldedName(std::string_view name);

class FilesBeside
{
public:
  explicit FilesBeside(std::filesystem::path base)
    : Base(std::move(base))
  {
  }

  // The file that `written` means, or where it should be if there is none. The first of these that
  // exists: the name as it is written; without quotes; up to a comment; as an address has it (%20);
  // with bytes that are not UTF-8 taken for Windows' Latin letters; in any case, if only one file
  // fits; the same by its last part, in base's folder. A folder's names are read once, the first
  // 65,536. Time: O(log n) of them.
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
