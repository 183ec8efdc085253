// SPDX-License-Identifier: BSD-3-Clause
// Finds out whether a mesh's file has textures, or colours of materials: then the readers of this
// folder are used for step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/texture/TexturedObj.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

struct FoundTextures
{
  bool any = false;
  bool colors = false; // materials without pictures, of several colours or of one that is not grey
  // Warnings for the user if there are no textures: missing materials.
  std::vector<std::string> warnings{};
  // There are no textures, and apart from the warnings nothing visible is lost: all materials in
  // use have one shade of grey.
  bool isPlain = false;
};

// For .obj, whose materials are read, and .ply (HasPictures); other formats have none here. Reads
// an .obj's text once for the names of libraries, and again if there are any; and, if materials
// have pictures or colours, until faces are found that use them. If all vertices of a file have
// colours, it keeps these instead of colours of materials, and instead of pictures that are missing
// or that no face uses. Errors: NotFound, InputOutput; errors in the mesh are left to its reader.
Result<FoundTextures> FindTextures(const std::filesystem::path& file);

// A file that has some: TexturedObj.h, TexturedPly.h.
Result<TexturedFile> ReadTextured(
  const std::filesystem::path& file, const Execution& execution = {});

}
