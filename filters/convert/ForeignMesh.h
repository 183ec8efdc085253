// SPDX-License-Identifier: BSD-3-Clause
// Meshes and point clouds of other programs' formats, read whole: step "convert" of the pipeline
// picture, kdstream-convert's work. All this runs in a process of its own, because the libraries
// that read these formats take unbounded memory and may crash on hostile input.
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

// What was read, with its attributes, and what the user should know of it: what was dropped.
struct ForeignMesh
{
  Mesh mesh;
  std::vector<std::string> warnings; // a sentence each, without the file's name
  std::optional<BakeReport> baked{}; // of a file whose textures were baked
  // What else it depends on, whether or not it is there: the files that the file names.
  std::vector<std::filesystem::path> named{};
  // What was dropped or repaired: counted here; the caller reports or refuses it (--strict).
  Tolerance tolerance{};
};

// Reads a file by its extension.
//   .vtp          VTK's XML; .vtk: VTK's legacy format, of a grid its surface
//   .wrl          VRML 2 (VRML 97); .glb, .gltf: glTF 2.0, the default scene, transforms applied
//   .json         a tileset of 3D Tiles: its finest tiles (ReadTileset)
//   .pcd          PCL's clouds: ascii, binary, compressed
//   .xyz          see ReadXyz; .las: see ReadLas
//   .ply .stl .obj .off  as kdstream-build reads them; corners of .stl in the same place are joined
// - Polygons and strips become triangles as in kdstream-build; degenerate triangles stay. Lines and
//   vertex cells are left out, with a warning unless they are those of a plain cloud.
// - Coordinates keep their type. Exceptions: those of .wrl, and of a text .pcd with SIZE 4, become
//   floats, with a warning if floats are too coarse. Other text becomes floats if these keep its
//   decimals distinct, else doubles.
// - Pictures are baked to vertex colours, as `textures` asks (BakeTextures.h), in .obj, .ply, .glb,
//   .gltf and .json.
// - Points that are not finite are dropped, with their triangles, and counted in `tolerance`.
//
// columns: of an .xyz, see ReadXyz. Peak memory: some three times the mesh. Errors: InvalidInput
// saying what is wrong, and where if the format's library reports it, and for a file without any
// point; Unsupported for other extensions, and for formats that this installation cannot read;
// InputOutput; NotFound; Cancelled.
Result<ForeignMesh> ReadForeignMesh(const std::filesystem::path& file,
  const TextureOptions& textures = {}, const Execution& execution = {},
  const std::string& columns = {});

// One function a format; the errors are those above.

Result<ForeignMesh> ReadVtp(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVtk(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution);

// The finest tiles (tiles/Tileset.h) of glTF (glb, gltf) and b3dm, with their transforms and
// pictures; z is up. Not carried, with a warning: tiles of other kinds, batch tables, skirts
// (primitives with "extras": { "skirt": true }, as kdstream-store exports them). Only files in the
// tileset's folder are read. Coordinates become doubles if floats would leave the whole mesh fewer
// than 2^16 steps. Memory: the mesh, and one tile.
Result<ForeignMesh> ReadTileset(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution);

// Text with a point in each line, its numbers separated by blanks, commas or semicolons. Where
// blanks or semicolons separate numbers that have one comma each and no point, these are decimal
// commas. Every line has as many columns as the first. The first of these that is given decides
// what the columns are:
// 1. columns ("x y z r g b class", separated by blanks or commas);
// 2. a line of these names before the first point;
// 3. x y z, and others by their values (XyzColumns.h). If the values of the first column cannot be
//    coordinates (XyzFirstColumn), it is the attribute "number", before x y z.
//
// Skipped: empty lines, lines that begin with # or //, text after a blank and #. A line with a
// single number gives the number of points up to the next such line; fewer points are an error.
// What can be read in two ways is reported (Tolerance::Tell, Lapse::ColumnsGuessed).
Result<ForeignMesh> ReadXyz(
  const std::filesystem::path& file, const std::string& columns, const Execution& execution);

// Uncompressed LAS 1.0 to 1.4 (LasHeader.h), doubles. Arrays: "RGB", "intensity", "classification",
// "return_number", each if its values differ; the rest of a point (times, angles, source, user
// data, waves) is not carried. Points marked as withheld are dropped. What the header claims is
// checked against the file's size before memory is taken for it.
Result<ForeignMesh> ReadLas(const std::filesystem::path& file, const Execution& execution);

// Through PCL. What the header claims is checked against the file's size before PCL takes memory
// for it. Fields: x y z; normal_x normal_y normal_z as "Normals"; rgb and rgba as colours; all
// others by their names.
Result<ForeignMesh> ReadPcd(const std::filesystem::path& file, const Execution& execution);

}
