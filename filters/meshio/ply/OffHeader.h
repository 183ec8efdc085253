// SPDX-License-Identifier: BSD-3-Clause
// OFF files are read as the text of a PLY. Its header is made from what their lines have. Part of
// step "read".
#pragma once

#include "filters/core/Execution.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/MeshReader.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// Text OFF as Geomview describes it: [ST][C][N]OFF; the numbers of vertices, faces and edges (on
// the same line too; edges on the next line, or missing); a line a vertex; a line a face, or, of
// OFF without colours and the like, all in one line. # begins a comment.
// - After x y z vertices have normals, colours and texture coordinates, as the first word says.
//   MeshLab writes colours before normals: this order is used if only then most normals have length
//   one. Faces have colours after their corners. They become the same arrays as nx ny nz, red green
//   blue alpha and s t of a PLY.
// - Colours are bytes if all are whole numbers up to 255, one above 1; else floats, which are shown
//   as those of a PLY.
// - Values that not all lines have are not read, and counted (Lapse::ValuesNotNamed).
// - A first word in lower case means the same: n is normals, not dimensions.
// - Coordinates are floats if these keep all decimals distinct, else doubles.
//
// Opening reads the whole text once. Memory: as PlyReader, and a line. Errors: those of PlyReader;
// InvalidInput for a file that is not OFF, missing numbers of vertices and faces, text in UTF-16, a
// line of more than 16 MiB; Unsupported for binary OFF, and for other than three dimensions;
// Cancelled. Opening is reported to the execution as "read".
Result<std::unique_ptr<MeshReader>> OpenOffReader(
  ByteSource source, const Execution& execution, const std::filesystem::path& scratch);

}
