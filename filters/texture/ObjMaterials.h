// SPDX-License-Identifier: BSD-3-Clause
// Materials of Wavefront OBJ files: their libraries, .mtl. Part of step "read" of the pipeline
// picture.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/FilesBeside.h"
#include "filters/texture/TexturedMesh.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// A material of a library, as far as it paints.
struct ObjMaterial
{
  std::string name, library;
  Color color{ 1, 1, 1, 1 }; // Kd, taken as sRGB; in linear light
  bool colored = false;      // whether there is a Kd
  bool ofBytes = false;      // which is from 0 to 255
  std::string picture;       // of map_Kd, as it is written; empty: none
  std::string place;         // of the map_Kd, for messages: "statue.mtl, line 4"
  bool clamp = false;
  std::array<double, 2> offset{}, scale{ 1, 1 }; // u, v up

  // Values that are not carried; the defaults are 0, black and opaque. `rough`: whether there is a
  // Pr below 1.
  double metalness = 0, emission = 0;
  std::optional<double> opacity{}, transparency{}; // d, Tr
  bool rough = false;
};

struct ObjMaterials
{
  std::vector<ObjMaterial> materials;             // of several with one name, the first
  std::vector<std::string> warnings;              // a sentence each, without the OBJ's name
  std::vector<std::filesystem::path> libraries{}; // the named libraries, even if missing
};

// The most libraries of a file, the most materials of all of them, and the largest size of one in
// bytes: more is left out, with a warning.
inline constexpr std::size_t mostObjLibraries = 256, mostObjMaterials = 1 << 16;
inline constexpr std::uint64_t mostObjLibraryBytes = std::uint64_t{ 1 } << 26;

// The libraries that the "mtllib" statements of the mesh's file name, one after the other.
// - line: of the statement.
// - A name with blanks is one name if there is such a file (FilesBeside::Find), else several names
//   (each up to a blank, or to .mtl): at most 256 in a statement, and at most 1,024 different
//   statements. Each file is read once.
// - Reads newmtl, Kd, and map_Kd with the options -o -s -clamp, whose picture may also be beside
//   the library.
// - Warnings: one for all other pictures; one each for Pm, Pr with it, Ke, and d or Tr, if their
//   values change something; one for a missing library, or a line that cannot be understood.
//
// Memory: the materials.
class ObjLibraries
{
public:
  explicit ObjLibraries(std::filesystem::path mesh)
    : Files(std::move(mesh))
  {
  }

  void Add(std::string_view names, std::uint64_t line);
  // If a mesh names materials but its libraries are missing: reads the library of the mesh's own
  // name, if there is one.
  void AddOwn();
  // The materials found. A warning names different materials of the same name. Call it last.
  ObjMaterials Take();

private:
  void TellTooMany(const std::string& what);
  void TellDifferent(const ObjMaterial& first, const ObjMaterial& other);
  // written: its name in that line.
  void Read(const std::filesystem::path& file, std::string_view asNamed, std::uint64_t line);

  FilesBeside Files;
  std::set<std::string, std::less<>> Statements; // the names in statements, as written
  std::vector<std::filesystem::path> Seen;
  ObjMaterials Found;
  std::vector<std::string> OtherMaps; // keywords of pictures that are not carried
  bool WarnedOfBytes = false;         // a warning says that a Kd is from 0 to 255
  bool TooMany = false, Opened = false;
  std::size_t Different = 0; // materials of a name that another has
};

// Finds materials by the names that faces use: as they are written; else without quotes and
// comments, and in any case and without blanks, if only one material fits.
class MaterialNames
{
public:
  // Of materials with one name the first counts.
  void Add(std::string_view name, std::uint32_t number);
  std::optional<std::uint32_t> Find(std::string_view name) const;

private:
  static std::string Fold(std::string_view name);

  std::map<std::string, std::uint32_t, std::less<>> Exact;
  // Nothing: several materials.
  std::map<std::string, std::optional<std::uint32_t>, std::less<>> Folded;
};

}
