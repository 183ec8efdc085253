// SPDX-License-Identifier: BSD-3-Clause
#include "filters/meshio/ContentFormat.h"

#include "filters/meshio/PlainText.h"

#include <algorithm>
#include <array>

namespace kdstream
{
namespace
{

struct Mark
{
  std::string_view begin, ending;
};

// By what the formats' own descriptions want there; archives, since people forget to unpack.
constexpr Mark marks[] = { { "ply\n", ".ply" }, { "ply\r", ".ply" }, { "glTF", ".glb" },
  { "LASF", ".las" }, { "# vtk DataFile", ".vtk" }, { "#VRML", ".wrl" }, { "# .PCD", ".pcd" },
  { "VERSION .7", ".pcd" }, { "<VTKFile", ".vtp" }, { "solid ", ".stl" }, { "solid\n", ".stl" },
  { "PK\x03\x04", ".zip" }, { "\x1f\x8b", ".gz" }, { "BZh", ".bz2" },
  { "\xFD"
    "7zXZ",
    ".xz" },
  { "\x28\xB5\x2F\xFD", ".zst" }, { "7z\xBC\xAF", ".7z" }, { "\x89PNG", ".png" },
  { "\xFF\xD8\xFF", ".jpg" }, { "%PDF", ".pdf" }, { "<!DOCTYPE", ".html" },
  { "<!doctype", ".html" }, { "<html", ".html" } };

bool IsSpace(char c)
{
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

}

std::string_view FormatOfContent(std::string_view begin)
{
  begin = begin.substr(0, contentFormatBytes);
  begin.remove_prefix(begin.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  begin.remove_prefix(static_cast<std::size_t>(
    std::find_if_not(begin.begin(), begin.end(), IsSpace) - begin.begin()));
  for (const Mark& mark : marks)
  {
    if (begin.starts_with(mark.begin))
    {
      return mark.ending;
    }
  }
  if (begin.starts_with("<?xml") && begin.find("<VTKFile") != std::string_view::npos)
  {
    return ".vtp";
  }
  if (begin.starts_with("{") && begin.find("\"asset\"") != std::string_view::npos)
  {
    return ".gltf";
  }
  return {};
}

std::string CompressedHint(std::string_view begin)
{
  constexpr std::array<std::array<std::string_view, 2>, 6> programs{ { { ".gz", "gunzip" },
    { ".zip", "unzip" }, { ".bz2", "bunzip2" }, { ".xz", "unxz" }, { ".zst", "unzstd" },
    { ".7z", "7z x" } } };
  if (begin.starts_with("version https://git-lfs.github.com/spec/"))
  {
    return "is a pointer of Git LFS, not the file that it stands for: run git lfs pull";
  }
  const std::string_view format = FormatOfContent(begin);
  const auto* const found = std::find_if(programs.begin(), programs.end(),
    [format](const auto& program) { return program[0] == format; });
  return found == programs.end() ? std::string()
                                 : "is compressed (" + std::string(format) +
                                     "): unpack it first, by " + std::string((*found)[1]);
}

std::string OtherFormatHint(std::string_view begin, std::string_view ending)
{
  if (std::string compressed = CompressedHint(begin); !compressed.empty())
  {
    return compressed;
  }
  const std::string_view format = FormatOfContent(begin);
  return format.empty() || format == ending
           ? std::string()
           : "looks like a " + std::string(format) + " file, although its name ends in " +
               std::string(ending);
}

}
