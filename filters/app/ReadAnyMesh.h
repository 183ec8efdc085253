// SPDX-License-Identifier: BSD-3-Clause
// A whole mesh from a file of any format that the programs take.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <string>

namespace kdstream
{

// Reads by MeshReader, or by kdstream-convert with its PLY in the system's folder for temporary
// files. Memory: the mesh. Errors: those of MeshReader and ConvertedInput, without the file's name.
Result<Mesh> ReadAnyMesh(const std::string& file, const Execution& execution);

}
