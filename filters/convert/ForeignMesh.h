// SPDX-License-Identifier: BSD-3-Clause
// Reads meshes and point clouds in other programs' formats as a whole: step "convert" of the
// pipeline picture, the work of kdstream-convert. All this runs in its own process, because the
// libraries that read these formats take unbounded memory and may crash on hostile input.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/Tolerance.h"
#include "filters/texture/BakeTextures.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// What was read, with its attributes, and what the user should know about it.
struct ForeignMesh
{
  Mesh mesh;
  std::vector<std::string> warnings; // one sentence each, without the file name
  std::optional<BakeReport> baked{}; // for a file whose textures were baked
  // The other files that the file names, whether they exist or not: the result depends on them.
  std::vector<std::filesystem::path> named{};
  // Counts data that was dropped or repaired; the caller reports it, or refuses it (--strict).
  Tolerance tolerance{};
};

// Reads a file by its extension.
//   .vtp          VTK's XML
//   .vtk          VTK's legacy format; of a grid, the surface
//   .wrl          VRML 2 (VRML 97)
//   .glb .gltf    glTF 2.0: the default scene, transforms applied
//   .json         a tileset of 3D Tiles: its finest tiles (ReadTileset)
//   .pcd          PCL's clouds: ascii, binary, compressed
//   .xyz          see ReadXyz
//   .las          see ReadLas
//   .ply .stl .obj .off  as kdstream-build reads them; corners of .stl in the same place are joined
// - Polygons and strips become triangles as in kdstream-build; degenerate triangles stay. Lines and
//   vertex cells are left out, with a warning unless they are the vertex cells of a plain cloud.
// - Coordinates keep their type, with two exceptions. Those of .wrl, and of a text .pcd with SIZE
//   4, become floats, with a warning if floats are too coarse. Those of other text files become
//   floats if floats keep the decimals distinct, else doubles.
// - For .obj, .ply, .glb, .gltf and .json, textures are baked to vertex colours, as `textures` asks
//   (BakeTextures.h).
// - Points that are not finite are dropped, with their triangles, and counted in `tolerance`.
//
// columns: for .xyz files, see ReadXyz. Peak memory: about three times the mesh. Errors:
// InvalidInput saying what is wrong, and where if the format's library reports it; also for a file
// without any point; Unsupported for other extensions, and for formats that this installation
// cannot read; InputOutput; NotFound; Cancelled.
Result<ForeignMesh> ReadForeignMesh(const std::filesystem::path& file,
  const TextureOptions& textures = {}, const Execution& execution = {},
  const std::string& columns = {});

// One function for each format; the errors are those above.

Result<ForeignMesh> ReadVtp(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVtk(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution);

// Reads the finest tiles (tiles/Tileset.h) of glTF (glb, gltf) and b3dm, with their transforms and
// pictures; z is up. A warning names what is not carried: tiles of other kinds, batch tables, and
// skirts (primitives with "extras": { "skirt": true }, as kdstream-store exports them). Only files
// in the tileset's folder are read. Coordinates become doubles if floats would leave the whole mesh
// fewer than 2^16 steps. Memory: the mesh, and one tile.
Result<ForeignMesh> ReadTileset(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution);

// Reads text with one point in each line, whose numbers are separated by blanks, commas or
// semicolons. If blanks or semicolons separate the numbers, and these have one comma each and no
// point, the commas are decimal commas. Every line has as many columns as the first one. The first
// of the following that is given decides what the columns are:
// 1. columns ("x y z r g b class", separated by blanks or commas);
// 2. a line before the first point, with the same kind of names;
// 3. x y z first, and the others by their values (XyzColumns.h). If the values of the first column
//    cannot be coordinates (XyzFirstColumn), it is the attribute "number", before x y z.
//
// Skipped: empty lines, lines that begin with # or //, and text after a blank and #. A line with a
// single number gives the number of points up to the next line of this kind; fewer points are an
// error. Ambiguous cases are reported (Tolerance::Tell, Lapse::ColumnsGuessed).
Result<ForeignMesh> ReadXyz(
  const std::filesystem::path& file, const std::string& columns, const Execution& execution);

// Reads uncompressed LAS 1.0 to 1.4 (LasHeader.h), as doubles. Arrays: "RGB", "intensity",
// "classification", "return_number", each if its values differ. The other fields of a point (times,
// angles, source, user data, waves) are not carried. Points marked as withheld are dropped. The
// header's claims are checked against the file's size before memory is allocated for them.
Result<ForeignMesh> ReadLas(const std::filesystem::path& file, const Execution& execution);

// Reads a cloud through PCL. The header's claims are checked against the file's size before PCL
// allocates memory for them. Fields: x y z; normal_x normal_y normal_z as "Normals"; rgb and rgba
// as colours; all others under their own names.
Result<ForeignMesh> ReadPcd(const std::filesystem::path& file, const Execution& execution);

}
