// SPDX-License-Identifier: BSD-3-Clause
// Reads whole Wavefront OBJ files with the pictures of their materials. Part of step "read" of the
// pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/meshio/Tolerance.h"
#include "filters/texture/TexturedMesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

struct TexturedFile
{
  TexturedMesh textured;
  std::vector<std::string> warnings; // one sentence each, without the file's name
  // Files that the file names, except pictures; also missing ones.
  std::vector<std::filesystem::path> libraries{};
  Tolerance tolerance{};
};

// Reads as ObjReader.h says, with these differences:
// - There is one vertex for each combination of place and normal, whatever texture coordinates its
//   corners have. "Normals" are carried. Vertex colours are not carried if there are pictures (with
//   a warning). Texture coordinates that are not numbers count as missing.
// - Materials are read as ObjMaterials.h says. A picture replaces Kd; v goes up; pictures repeat,
//   unless -clamp on clamps them. <UDIM> in a picture's name is the number of the tile, 1001 + u +
//   10 v, for tiles of u < 10 and v < 100. A material that no library has is white, with a warning
//   that names the line.
//
// The text is read twice. Memory: the mesh, 12 bytes for each texture coordinate, and 60 for each
// triangle. Errors, with the number of the line and of the vertex or face: those of ObjReader.h;
// LimitExceeded for more than 2^32 - 2 elements of any kind.
Result<TexturedFile> ReadTexturedObj(
  const std::filesystem::path& file, const Execution& execution = {});

}
