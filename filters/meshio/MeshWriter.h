// SPDX-License-Identifier: BSD-3-Clause
// Writing a mesh: .ply (binary, little endian), .stl (binary), .obj, .vtp and .wrl.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Writes `mesh` in the format of the file's extension. The file appears whole or not at all: it is
// written under a temporary name beside it and renamed.
//   .ply   all attributes bit for bit, under the names of PlyArrays.h
//   .vtp   all attributes bit for bit
//   .obj   colours, normals, texture coordinates
//   .wrl   colours, normals
//   .stl   no attributes; the normals are those of the triangles, by the right-hand rule, and zero
//          for degenerate triangles
// A normal that is not finite is written as (0, 0, 0) in .obj and .wrl. Coordinates are written in
// mesh.scalarType, bit for bit. (STL has only floats; text formats get the shortest decimals that
// read back to the same value.) For a mesh without triangles, a point cloud, .ply and .obj have
// only vertices, .vtp has one vertex cell a point, .wrl a PointSet; .stl is refused.
//
// Memory: one block of 1 MiB. Errors: InvalidArgument for another extension, and for points without
// triangles in STL; InvalidInput for a triangle with an index out of range, and for attributes that
// CheckAttributes or IsAttributeName refuses; LimitExceeded for more than 2^31 points (the formats'
// indices are signed), or more than 2^32 - 1 triangles in STL; InputOutput with the system's
// reason; Cancelled.
Status WriteMesh(
  const std::filesystem::path& file, const Mesh& mesh, const Execution& execution = {});

// Whether WriteMesh knows the file's extension.
bool IsWritable(const std::filesystem::path& file);

// The names of the attributes that WriteMesh leaves out of that file.
std::vector<std::string> AttributesLeftOut(const std::filesystem::path& file, const Mesh& mesh);

// What the file's format cannot hold of the mesh, one sentence each, for warnings: attributes and,
// for STL, doubles.
std::vector<std::string> LossesOfFormat(const std::filesystem::path& file, const Mesh& mesh);

}
