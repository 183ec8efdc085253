// SPDX-License-Identifier: BSD-3-Clause
// Reads Wavefront OBJ files in chunks: step "read" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

namespace kdstream
{

// The name of materials in Info().ignoredAttributes.
inline constexpr const char* objMaterialsName = "materials and their textures";

// What is read of an OBJ file:
// - places (v, without w), and colours after the coordinates ("RGB", uint8), if all places have
//   one. In the file, colours go from 0 to 1, or to 255 if one is above 1;
// - faces of any number of corners, whose numbers count from 1, or back from the face; lines that a
//   backslash continues;
// - texture coordinates ("TCoords", two floats; if a line has three, the first two) and normals
//   ("Normals", three floats) that corners name. Each combination of place, texture coordinate and
//   normal is a vertex of its own, with zeros where a corner names none.
//
// Skipped: groups, objects, smoothing, parameters, points. Skipped and named in
// Info().ignoredAttributes: materials, lines and free-form shapes, and colours that not all places
// have. Coordinates are floats if floats keep all decimals distinct, else doubles.
//
// A face may name any place of the file, so faces are read after all places. The text is read three
// times; the first time, when it is opened, only counts. Memory: one block of the file, and the
// data appended to the caller's vectors. If corners name texture coordinates or normals, opening
// makes tables on disk (ObjVertices.h), which takes about 10 MiB more memory. They lie in
// `scratch`, or if that is empty in the system's folder for temporary files.
//
// Dropped and counted: faces of fewer than three corners; the texture coordinates (or normals) of a
// face, if one of its corners names one that does not exist. This reader can return points that are
// not finite: see FiniteReader.h.
//
// Errors, with the number of the line and of the vertex or face: InvalidInput for a file without
// any OBJ statement, text in UTF-16, text in place of a number, too many or too few numbers, a
// place that does not exist, a statement of more than 16 MiB; LimitExceeded for more than 2^32 - 2
// vertices; InputOutput; Cancelled. The execution sees opening as step "read".
Result<std::unique_ptr<MeshReader>> OpenObjReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch);

}
