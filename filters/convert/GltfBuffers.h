// SPDX-License-Identifier: BSD-3-Clause
// The bytes that a glTF keeps its geometry in, checked before VTK reads: it crashes without them,
// or takes what it finds.
#pragma once

#include "filters/core/Result.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <vector>

namespace kdstream
{

// Whether each file that the buffers name is there, below the folder, and as long as they claim.
// json: of the glTF, which lies in the folder. All that is wrong otherwise is left to the reader.
// Errors: InvalidInput naming the file.
Status CheckGltfBuffers(const nlohmann::json& json, const std::filesystem::path& folder);

// Whether what accessors claim lies in their views, and these in their buffers. What is not there
// at all is left to the reader. Errors: InvalidInput naming the accessor.
Status CheckGltfAccessors(const nlohmann::json& json);

// Those files. REQUIRES: they are checked.
std::vector<std::filesystem::path> GltfBufferFiles(
  const nlohmann::json& json, const std::filesystem::path& folder);

}
