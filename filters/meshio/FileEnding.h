// SPDX-License-Identifier: BSD-3-Clause
// The ending that names a file's format: for readers and writers.
#pragma once

#include <filesystem>
#include <string>

namespace kdstream
{

// ".ply" for "Dragon.PLY"; empty if there is none. Only ASCII letters are made small, whatever the
// locale.
inline std::string FileEnding(const std::filesystem::path& file)
{
  std::string ending = file.extension().string();
  for (char& c : ending)
  {
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return ending;
}

}
