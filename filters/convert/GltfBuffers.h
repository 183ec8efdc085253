// SPDX-License-Identifier: BSD-3-Clause
// The bytes that a glTF keeps its geometry in, checked before VTK reads: it crashes without them,
// or takes what it finds.
#pragma once

#include "filters/convert/GltfDocument.h"
#include "filters/core/Result.h"

#include <filesystem>
#include <vector>

namespace kdstream
{

// Whether each buffer is there, files below the folder, and as long as it claims. The document's
// file lies in the folder. Errors: InvalidInput naming the file or the buffer.
Status CheckGltfBuffers(const GltfDocument& document, const std::filesystem::path& folder);

// The files of buffers. REQUIRES: they are checked.
std::vector<std::filesystem::path> GltfBufferFiles(
  const nlohmann::json& json, const std::filesystem::path& folder);

}
