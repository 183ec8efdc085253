// SPDX-License-Identifier: BSD-3-Clause
// Reads whole PLY files with textures. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/meshio/ply/PlyHeader.h"
#include "filters/texture/TexturedObj.h"

#include <filesystem>

namespace kdstream
{

// Whether a file with this header has faces, pictures ("comment TextureFile") and texture
// coordinates: a list "texcoord" of faces, or else u v of vertices by any of their names
// (PlyArrays.h).
bool HasPictures(const PlyHeader& header);

// Whether the vertices have colours.
bool HasColorsOfVertices(const PlyHeader& header);

// Reads as PlyReader.h says, with the pictures. `texcoord` has u v for each corner of its face; v
// goes up. `texnumber` is the number of the picture; without it, the first picture is used.
// Pictures are searched for by FileBeside, and repeat. "RGB", "RGBA" and "TCoords" are not carried,
// because the pictures replace them; a warning names colours that are dropped.
//
// A texcoord counts as missing if it does not have two numbers for each corner. (If no face has a
// texcoord, the coordinates of vertices are used, if there are any.) A texnumber without a picture
// counts as no picture. Warnings name the first face in question. Memory: the mesh, and 60 bytes a
// triangle. Errors: those of PlyReader.h; Unsupported for triangle strips with pictures.
Result<TexturedFile> ReadTexturedPly(
  const std::filesystem::path& file, const Execution& execution = {});

}
