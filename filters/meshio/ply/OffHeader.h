// SPDX-License-Identifier: BSD-3-Clause
// Reads OFF files as the text of a PLY, with a header made from what the lines hold. Part of step
// "read".
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// Text OFF as Geomview describes it: first [ST][C][N]OFF; then the numbers of vertices, faces and
// edges, which may follow on the same line (edges may also be on the next line, or missing); then
// one line for each vertex and one for each face. A plain OFF without colours, normals or texture
// coordinates may have everything in one line. # begins a comment.
// - After x y z, vertices have normals, colours and texture coordinates, as the first word says.
//   MeshLab writes colours before normals; this order is assumed if most normals have length one
//   only in this order. Faces have colours after their corners. These values become the same arrays
//   as nx ny nz, red green blue alpha and s t of a PLY.
// - Colours are bytes if all are whole numbers up to 255 and at least one is above 1. Else they are
//   floats, which are shown as those of a PLY are.
// - Values that not all lines have are not read, but counted (Lapse::ValuesNotNamed).
// - A first word in lower case means the same: n is normals, not dimensions.
// - Coordinates are floats if floats keep all decimals distinct, else doubles.
//
// Opening reads the whole text once. Memory: as PlyReader, and one line. Errors: those of
// PlyReader; InvalidInput for a file that is not OFF, missing numbers of vertices and faces, text
// in UTF-16, a line of more than 16 MiB; Unsupported for binary OFF, and for a number of dimensions
// other than three; Cancelled. The execution sees opening as step "read".
Result<std::unique_ptr<MeshReader>> OpenOffReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch);

}
