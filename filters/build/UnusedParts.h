// SPDX-License-Identifier: BSD-3-Clause
// Writes the list of vertices that no triangle uses into a store: in parts that are encoded as
// pieces of a cloud, with exact coordinates. Step "encode" of the pipeline picture, for all
// builders.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/store/StoreWriter.h"

#include <span>

namespace kdstream
{

// Writes the list after everything else, if the model has unused vertices. unused: as
// TakeUnusedVertices returns them, or files of them, in the order of the input. attributes: of the
// model. Memory: a part and its bytes. Errors: those of the writer; InputOutput; Cancelled.
Status WriteUnused(const Mesh& unused, StoreWriter& writer, const Execution& execution = {});
Status WriteUnused(const VertexFiles& unused, std::span<const AttributeInfo> attributes,
  ScalarType scalarType, StoreWriter& writer, const Execution& execution = {});

}
