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

  // The file as it is written; else without quotes around its name; else up to a comment; else as
  // an address has it (%20); else with bytes that are not UTF-8 taken for Windows' Latin letters;
  // else without regard to case, where one file alone fits; else the same by its last part, in
  // base's folder. Where there is none: where it should be. The folders' names are read once, of
  // each the first 65,536. Time: O(log n) of them.
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
