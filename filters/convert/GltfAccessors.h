// SPDX-License-Identifier: BSD-3-Clause
// What the meshes of a glTF claim of its buffers, checked before VTK reads: it takes what it finds.
#pragma once

#include "filters/convert/GltfDocument.h"
#include "filters/core/Result.h"

#include <optional>
#include <string>

namespace kdstream
{

// Whether what accessors claim lies in their views, and these in their buffers. Errors:
// InvalidInput naming the accessor.
Status CheckGltfAccessors(const GltfDocument& document);

// Whether nodes name meshes, and their parts accessors, that are there and of a kind that is read,
// and all attributes of a part have as many elements; whether places of nodes are numbers. Errors:
// InvalidInput naming node or part.
Status CheckGltfMeshes(const nlohmann::json& json);

// A sentence, where triangles of parts have corners that are no multiple of three: the last ones
// are left out. REQUIRES: CheckGltfMeshes.
std::optional<std::string> IncompleteGltfTriangles(const nlohmann::json& json);

}
