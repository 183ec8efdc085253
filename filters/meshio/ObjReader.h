// SPDX-License-Identifier: BSD-3-Clause
// Reads Wavefront OBJ files in chunks: step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

namespace kdstream
{

// What Info().ignoredAttributes calls materials.
inline constexpr const char* objMaterialsName = "materials and their textures";

// What is read of an OBJ:
// - places (v, without w), and colours after the coordinates ("RGB", uint8: from 0 to 1 in the
//   file, or to 255 where one is above 1; only if all places have one);
// - faces of any number of corners, with numbers from 1 on or back from the face; lines that a
//   backslash continues;
// - texture coordinates ("TCoords", two floats; of three the first two) and normals ("Normals",
//   three floats) that corners name. Each combination of place, texture coordinate and normal is a
//   vertex of its own, with zeros where a corner names none.
//
// Skipped: groups, objects, smoothing, parameters, points. Skipped and named in
// Info().ignoredAttributes: materials, lines and free-form shapes, and colours that not all places
// have. Coordinates are floats if these keep all decimals distinct, else doubles.
//
// A face may name any place of the file, so faces are read after all places. The text is read three
// times, the first time when it is opened, to count. Memory: one block of the file, and what is
// appended to the caller's vectors. If corners name texture coordinates or normals, tables on disk
// are made when the file is opened (ObjVertices.h), in `scratch`, or if that is empty in the
// system's folder for temporary files; memory is some 10 MiB more then.
//
// Dropped and counted: faces of fewer than three corners; the texture coordinates (or normals) of a
// face, if one of its corners names one that does not exist. Points may not be finite: see
// FiniteReader.h.
//
// Errors, with the number of the line and of the vertex or face: InvalidInput for a file without
// any statement of OBJ, text in UTF-16, text in place of a number, too many or too few numbers, a
// place that does not exist, a statement of more than 16 MiB; LimitExceeded for more than 2^32 - 2
// vertices; InputOutput; Cancelled. Opening is reported to the execution as "read".
Result<std::unique_ptr<MeshReader>> OpenObjReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch);

}
