// SPDX-License-Identifier: BSD-3-Clause
// Reads the materials of Wavefront OBJ files from their libraries, .mtl. Part of step "read" of the
// pipeline picture.
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

// A material of a library: the values that determine its colours.
struct ObjMaterial
{
  std::string name, library;
  Color color{ 1, 1, 1, 1 }; // Kd, taken as sRGB; in linear light
  bool colored = false;      // whether there is a Kd
  bool ofBytes = false;      // whether Kd is from 0 to 255
  std::string picture;       // file name in map_Kd, as written; empty if none
  std::string place;         // where map_Kd is, for messages: "statue.mtl, line 4"
  bool clamp = false;
  std::array<double, 2> offset{}, scale{ 1, 1 }; // for u and v; v goes up

  // Values that are not carried; the defaults are 0, black and opaque. `rough`: whether there is a
  // Pr below 1.
  double metalness = 0, emission = 0;
  std::optional<double> opacity{}, transparency{}; // d, Tr
  bool rough = false;
};

struct ObjMaterials
{
  std::vector<ObjMaterial> materials;             // if several have the same name, the first
  std::vector<std::string> warnings;              // one sentence each, without the OBJ's name
  std::vector<std::filesystem::path> libraries{}; // all named libraries, even missing ones
};

// Limits: the libraries of a file, the materials of all libraries together, and the bytes of one
// library. Anything beyond is left out, with a warning.
inline constexpr std::size_t mostObjLibraries = 256, mostObjMaterials = 1 << 16;
inline constexpr std::uint64_t mostObjLibraryBytes = std::uint64_t{ 1 } << 26;

// Reads the libraries that the "mtllib" statements of the mesh's file name, one after the other.
// - line: where the statement is.
// - A name with blanks is one name if this file exists (FilesBeside::Find), else several names
//   (each up to a blank, or to .mtl). Limits: 256 names in a statement, 1,024 different statements.
//   Each file is read once.
// - Reads newmtl, Kd, and map_Kd with the options -o -s -clamp. Its picture may also be in the
//   library's folder.
// - Warnings: one for all other textures; one each for Pm, Pr with it, Ke, and d or Tr, if their
//   values change something; one for each missing library, and for each line that cannot be
//   understood.
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
  // If a mesh names materials, but all its libraries are missing: reads the library with the mesh's
  // own name, if there is one.
  void AddOwn();
  // Returns the materials found. A warning names different materials of the same name. Call it
  // last.
  ObjMaterials Take();

private:
  void TellTooMany(const std::string& what);
  void TellDifferent(const ObjMaterial& first, const ObjMaterial& other);
  // asNamed: the library's name in that line.
  void Read(const std::filesystem::path& file, std::string_view asNamed, std::uint64_t line);

  FilesBeside Files;
  std::set<std::string, std::less<>> Statements; // names in statements so far, as written
  std::vector<std::filesystem::path> Seen;
  ObjMaterials Found;
  std::vector<std::string> OtherMaps; // keywords of textures that are not carried
  bool WarnedOfBytes = false;         // a warning has reported a Kd from 0 to 255
  bool TooMany = false, Opened = false;
  std::size_t Different = 0; // how many differ from one of the same name
};

// Finds materials by the names that faces use. Tries the name as written; then without quotes and
// comments; then ignoring case and blanks, if only one material fits.
class MaterialNames
{
public:
  // If several materials have the same name, the first counts.
  void Add(std::string_view name, std::uint32_t number);
  std::optional<std::uint32_t> Find(std::string_view name) const;

private:
  static std::string Fold(std::string_view name);

  std::map<std::string, std::uint32_t, std::less<>> Exact;
  // By folded name; nothing if several materials have it.
  std::map<std::string, std::optional<std::uint32_t>, std::less<>> Folded;
};

}
