// SPDX-License-Identifier: BSD-3-Clause
// Whether a mesh's file is painted by pictures, or by colours of materials: step "read" of the
// pipeline picture goes another way then.
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
  bool colors = false; // any, but no picture: materials of several colours, or one that is not grey
  // What the user should know where there are none: materials that are not there.
  std::vector<std::string> warnings{};
};

// Of an .obj, whose materials are read, and a .ply (HasPictures); other files have none. Goes
// through an .obj's text once for the names of libraries, and again if there are any; and, if
// materials have pictures or such colours, until faces are found that use them. A file with colours
// of all its vertices keeps those instead of colours of materials, and instead of pictures where no
// face uses one that is there. Errors:
// NotFound, InputOutput; what is wrong in the mesh is left to its reader.
Result<FoundTextures> FindTextures(const std::filesystem::path& file);

// A file that has some: TexturedObj.h, TexturedPly.h.
Result<TexturedFile> ReadTextured(
  const std::filesystem::path& file, const Execution& execution = {});

}
