// SPDX-License-Identifier: BSD-3-Clause
// The files that a .gltf keeps its geometry in, checked before VTK reads: it crashes without them.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>

namespace kdstream
{

// Whether each file that the buffers of a .gltf name is there and as long as they claim. All that
// is wrong otherwise is left to the reader. Peak memory: some times the .gltf.
// Errors: InvalidInput naming the file; InputOutput.
Status CheckGltfBuffers(const std::filesystem::path& file);

}
