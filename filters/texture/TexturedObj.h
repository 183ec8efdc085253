// SPDX-License-Identifier: BSD-3-Clause
// Reads Wavefront OBJ files, with the pictures of their materials, as a whole. Part of step "read"
// of the pipeline picture.
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
  std::vector<std::string> warnings; // a sentence each, without the file's name
  // Files that the file names besides pictures, even if missing.
  std::vector<std::filesystem::path> libraries{};
  Tolerance tolerance{};
};

// As ObjReader.h, with these differences:
// - One vertex for each combination of place and normal, whatever texture coordinates its corners
//   have. "Normals" are carried. Colours of vertices are not carried if there are pictures (with a
//   warning). Texture coordinates that are not numbers count as missing.
// - Materials as in ObjMaterials.h: a picture replaces Kd, v goes up, -clamp on clamps, else
//   pictures repeat. <UDIM> in a picture's name is the number of the tile, 1001 + u + 10 v, for
//   tiles of u < 10 and v < 100. A material that no library has is white, with a warning that names
//   the line.
//
// The text is read twice. Memory: the mesh, 12 bytes a texture coordinate, and 60 a triangle.
// Errors, with the number of the line and of the vertex or face: those of ObjReader.h;
// LimitExceeded for more than 2^32 - 2 of anything.
Result<TexturedFile> ReadTexturedObj(
  const std::filesystem::path& file, const Execution& execution = {});

}
