// Writing a mesh: .ply (binary, little endian), .stl (binary), .obj, .vtp and .wrl.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <filesystem>

namespace kdstream
{

// Writes `mesh` in the format that the file's name ends in. Coordinates are written in
// mesh.scalarType, bit for bit (STL has floats only; text formats get the shortest decimals that
// read back to the same value). The file appears whole or not at all: it is written under a
// temporary name beside it and renamed. Errors: Unsupported for another ending; InputOutput, naming
// the file and the system's reason.
Status WriteMesh(const std::filesystem::path& file, const Mesh& mesh);

}
