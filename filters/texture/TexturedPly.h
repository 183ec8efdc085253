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

// As PlyReader.h reads it, with the pictures: `texcoord` has u v for each corner of its face, v up;
// `texnumber` the number of the picture, without it the first one. Pictures are looked for as
// FileBeside tells, and repeat. "RGB", "RGBA" and "TCoords" are not carried: pictures paint
// instead; a warning names colours that go. A texcoord of another length than two for each corner
// counts as none (where no face has one, coordinates of vertices count, if there are some), and a
// texnumber that no picture has as no picture, with warnings that name the first face. Memory: the
// mesh and 60 bytes a triangle. Errors: those of PlyReader.h; Unsupported for triangle strips with
// pictures.
Result<TexturedFile> ReadTexturedPly(
  const std::filesystem::path& file, const Execution& execution = {});

}
