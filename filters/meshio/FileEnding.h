// SPDX-License-Identifier: BSD-3-Clause
// The ending that names a file's format, for readers and writers.
#pragma once

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>

namespace kdstream
{

// ".ply" for "Dragon.PLY"; empty if there is none. Only ASCII letters become lower case, whatever
// the locale.
inline std::string FileEnding(const std::filesystem::path& file)
{
  std::string ending = file.extension().string();
  for (char& c : ending)
  {
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return ending;
}

// Whether the ending is one that programs give to points written as lines of numbers, such as .xyz.
inline bool IsPointText(const std::string& ending)
{
  constexpr const char* endings[] = { ".xyz", ".txt", ".csv", ".pts", ".asc", ".xyzrgb", ".xyzn" };
  return std::find(std::begin(endings), std::end(endings), ending) != std::end(endings);
}

// Whether only kdstream-convert reads the format. A .wrz file is a .wrl compressed with gzip; a
// .json file is a tileset of 3D Tiles.
inline bool IsConvertedFormat(const std::string& ending)
{
  constexpr const char* endings[] = { ".vtp", ".vtk", ".wrl", ".wrz", ".glb", ".gltf", ".json",
    ".pcd", ".las", ".laz" };
  return IsPointText(ending) ||
         std::find(std::begin(endings), std::end(endings), ending) != std::end(endings);
}

}
