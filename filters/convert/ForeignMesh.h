// SPDX-License-Identifier: BSD-3-Clause
// Meshes and point clouds of other programs' formats, read whole: step "convert" of the
// README's picture, kdstream-convert's work. Everything here runs in a process of its own, since
// the libraries that read these formats take what memory they like and may end with it on hostile
// input.
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
  std::optional<BakeReport> baked{}; // of a file with textures, if they were
  // What else it depends on, whether or not it is there: the files that the file names.
  std::vector<std::filesystem::path> named{};
  // What was dropped or forgiven: counted here, and told and refused (--strict) by who asked.
  Tolerance tolerance{};
};

// Reads a file by its ending. Polygons become fans and strips triangles as kdstream-build reads
// them, degenerate triangles stay; lines and vertex cells are left out, with a warning unless they
// are those of a plain cloud. Coordinates keep their type, but those of .wrl, and of a
// .pcd as text with SIZE 4, are floats, with a warning where these are coarse; other text is read
// as floats where these tell its decimals apart, else as doubles.
//   .vtp          VTK's XML; .vtk: VTK's legacy format, of a grid its surface
//   .wrl          VRML 2 (VRML 97); .glb, .gltf: glTF 2.0, the default scene, transforms applied
//   .pcd          PCL's clouds: ascii, binary, compressed; points that are not finite are dropped
//   .xyz          see ReadXyz; .las: see ReadLas
//   .ply .stl .obj  as kdstream-build reads them; corners of .stl in the same place are joined
// Pictures are baked to colours of vertices, as textures asks (BakeTextures.h), in .obj, .ply,
// .glb and .gltf.
// Peak memory: some three times the mesh. Errors: InvalidInput saying what is wrong, and where if
// the format's library tells; a file without any point; Unsupported for other endings, and for what
// this installation lacks; InputOutput; NotFound; Cancelled.
Result<ForeignMesh> ReadForeignMesh(const std::filesystem::path& file,
  const TextureOptions& textures = {}, const Execution& execution = {});

// One function a format; the errors are those above.

Result<ForeignMesh> ReadVtp(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVtk(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution);
Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution);

// Text, a point a line, its numbers apart by blanks, commas or semicolons. Columns: x y z, then
// nothing; an intensity; r g b or nx ny nz; intensity r g b; or r g b nx ny nz. Three further
// columns are a normal if all of them are of length one (or zero: no normal), colours if all of
// them are whole numbers from 0 to 255, else plain numbers, "column4" and so on; a warning tells
// where that is not obvious. Every line has as many columns as the first. Passed over: empty lines,
// lines that begin with # or //, and a first line with only the number of points. Points that are
// not finite are dropped.
Result<ForeignMesh> ReadXyz(const std::filesystem::path& file, const Execution& execution);

// Uncompressed LAS 1.0 to 1.4 (LasHeader.h), doubles. Arrays: "RGB", "intensity", "classification",
// "return_number", each where it says something; the rest of a point (times, angles, source, user
// data, waves) is not carried. Points that are marked as withheld are dropped. What the header
// claims is checked against the file's size before memory is taken for it.
Result<ForeignMesh> ReadLas(const std::filesystem::path& file, const Execution& execution);

// Through PCL. What the header claims is checked against the file's size before PCL takes memory
// for it. Fields: x y z; normal_x normal_y normal_z as "Normals"; rgb and rgba as colours; all
// others by their names.
Result<ForeignMesh> ReadPcd(const std::filesystem::path& file, const Execution& execution);

}
