// SPDX-License-Identifier: BSD-3-Clause
// Writing a mesh: .ply (binary, little endian), .stl (binary), .obj, .vtp and .wrl.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// Writes `mesh` in the format that the file's name ends in, with the attributes that it knows: .ply
// and .vtp all of them bit for bit (.ply under the names that PlyArrays.h tells), .obj colours,
// normals and texture coordinates, .wrl colours and normals, .stl none; a normal that is not finite
// is (0, 0, 0) in .obj and .wrl. Coordinates are written in
// mesh.scalarType, bit for bit (STL has floats only; text formats get the shortest decimals that
// read back to the same value). The file appears whole or not at all: it is written under a
// temporary name beside it and renamed. A mesh without triangles is a point cloud: .ply and .obj
// have vertices only then, .vtp one vertex cell a point, .wrl a PointSet; .stl knows triangles only
// and is refused. STL normals are those of the corners in counter-clockwise order, zero for
// degenerate triangles. Memory: one block of 1 MiB. Errors: InvalidArgument for another ending, and
// for points alone in STL; InvalidInput for a triangle whose index is out of range, for attributes
// that CheckAttributes or IsAttributeName refuses; LimitExceeded for more than 2^31 points (the
// formats' indices are signed), or more than 2^32 - 1 triangles in STL; InputOutput with the
// system's reason.
Status WriteMesh(const std::filesystem::path& file, const Mesh& mesh);

// The names of the attributes that WriteMesh leaves out of that file.
std::vector<std::string> AttributesLeftOut(const std::filesystem::path& file, const Mesh& mesh);

// What that file does not hold of the mesh, a sentence each, for a warning: attributes; in STL also
// doubles.
std::vector<std::string> LossesOfFormat(const std::filesystem::path& file, const Mesh& mesh);

}
