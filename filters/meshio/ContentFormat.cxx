// SPDX-License-Identifier: BSD-3-Clause
#include "filters/meshio/ContentFormat.h"

#include "filters/meshio/FileEnding.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/TextWords.h"

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
  { "<!doctype", ".html" }, { "<html", ".html" }, { "Kaydara FBX Binary", ".fbx" },
  { "; FBX ", ".fbx" }, { "ISO-10303-21", ".step" }, { "ASTM-E57", ".e57" }, { "DRACO", ".drc" } };

// Meshes that are not read, whatever their name.
constexpr std::string_view unread[] = { ".fbx", ".step", ".e57", ".drc", ".dae", ".x3d" };

// Exactly the triangles that it counts behind the header: no other file is so by chance.
bool IsBinaryStl(std::string_view begin, std::uint64_t size)
{
  constexpr std::size_t header = 84;
  if (size <= header || begin.size() < header)
  {
    return false;
  }
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
  {
    count |= std::uint64_t{ static_cast<unsigned char>(begin[header - 4 + i]) } << (8 * i);
  }
  return size == header + 50 * count;
}

// Of a text without a mark: by the first word of its first line that is no comment. Too little to
// be believed of what could be binary.
std::string_view FormatOfText(std::string_view begin)
{
  begin.remove_prefix(begin.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  TakeBlanks(begin);
  while (begin.starts_with('#'))
  {
    begin.remove_prefix(std::min(begin.find_first_of("\r\n"), begin.size()));
    TakeBlanks(begin);
  }
  const std::string_view word = TakeWord(begin);
  constexpr std::string_view ofObj[] = { "v", "vn", "vt", "f", "g", "o", "mtllib", "usemtl" };
  constexpr std::string_view ofOff[] = { "OFF", "COFF", "NOFF", "STOFF", "CNOFF", "NCOFF" };
  return std::find(std::begin(ofObj), std::end(ofObj), word) != std::end(ofObj)   ? ".obj"
         : std::find(std::begin(ofOff), std::end(ofOff), word) != std::end(ofOff) ? ".off"
                                                                                  : "";
}

bool IsRead(const std::string& ending)
{
  return ending == ".ply" || ending == ".stl" || ending == ".obj" || ending == ".off" ||
         IsConvertedFormat(ending);
}

}

std::string_view FormatOfContent(std::string_view begin, std::uint64_t size)
{
  const bool isStl = IsBinaryStl(begin, size);
  begin = begin.substr(0, contentFormatBytes);
  begin.remove_prefix(begin.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  TakeBlanks(begin);
  for (const Mark& mark : marks)
  {
    if (begin.starts_with(mark.begin))
    {
      return mark.ending;
    }
  }
  for (const auto& [mark, ending] : { std::array<std::string_view, 2>{ "<VTKFile", ".vtp" },
         { "<COLLADA", ".dae" }, { "<X3D", ".x3d" } })
  {
    if (begin.starts_with("<") && begin.find(mark) != std::string_view::npos)
    {
      return ending;
    }
  }
  if (begin.starts_with("{") && begin.find("\"asset\"") != std::string_view::npos)
  {
    return ".gltf";
  }
  return isStl ? ".stl" : std::string_view();
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

std::string OtherFormatHint(std::string_view begin, std::string_view ending, std::uint64_t size)
{
  if (std::string compressed = CompressedHint(begin); !compressed.empty())
  {
    return compressed;
  }
  std::string format(FormatOfContent(begin, size));
  format = format.empty() ? FormatOfText(begin) : format;
  if (format.empty() || format == ending || (format == ".gltf" && ending == ".glb"))
  {
    return {};
  }
  const bool isUnread = std::find(std::begin(unread), std::end(unread), format) != std::end(unread);
  return "looks like a " + format + " file, although its name ends in " + std::string(ending) +
         (IsRead(format) ? ": rename it to end in " + format
           : isUnread    ? ", and such files are not read: convert it to .ply"
                         : "");
}

}
