// SPDX-License-Identifier: BSD-3-Clause
// PLY files that pictures paint, read whole. Part of step "read" of the pipeline picture.
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

// Whether its vertices have colours.
bool HasColorsOfVertices(const PlyHeader& header);

// As PlyReader.h, with the pictures: `texcoord` has u v for each corner of its face, v up;
// `texnumber` the number of the picture, without it the first one. Pictures are searched for by
// FileBeside, and repeat. "RGB", "RGBA" and "TCoords" are not carried, because the pictures replace
// them; a warning names colours that are dropped. A texcoord of another length than two for each
// corner counts as missing (if no face has a texcoord, coordinates of vertices are used, if there
// are any). A texnumber without a picture counts as no picture. Warnings name the first such face.
// Memory: the mesh and 60 bytes a triangle. Errors: those of PlyReader.h; Unsupported for triangle
// strips with pictures.
Result<TexturedFile> ReadTexturedPly(
  const std::filesystem::path& file, const Execution& execution = {});

}
