// SPDX-License-Identifier: BSD-3-Clause
// Finds out whether a mesh's file has textures, or colours of materials. If so, step "read" of the
// pipeline picture uses the readers of this folder.
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
  bool colors = false; // materials have colours: several, or one that is not grey
  // Warnings for the user about missing materials, if there are no textures.
  std::vector<std::string> warnings{};
  // There are no textures, and nothing visible is lost except what the warnings say: all materials
  // in use have the same shade of grey.
  bool isPlain = false;
};

// For .obj files, whose materials are read, and .ply files (HasPictures); other formats have no
// textures here. Reads the text of an .obj once for the names of libraries, and again if there are
// any. If materials have pictures or colours, goes on until faces are found that use them. If all
// vertices of a file have colours, the file keeps these. They then replace colours of materials,
// and pictures that are missing or that no face uses. Errors: NotFound, InputOutput; errors in the
// mesh are left to its reader.
Result<FoundTextures> FindTextures(const std::filesystem::path& file);

// Reads a file that has textures or material colours: TexturedObj.h, TexturedPly.h.
Result<TexturedFile> ReadTextured(
  const std::filesystem::path& file, const Execution& execution = {});

}
