// SPDX-License-Identifier: BSD-3-Clause
// A model's preview as the bytes of a .glb for augmented reality: for kdstream-store export.
#pragma once

#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// y up, the front towards +z, standing on the origin, in metres; a model whose unit is not known is
// as long as a metre. Floats, because the viewers of phones know no extensions. Empty for a cloud,
// and where the store has no levels. Errors: those of the store.
Result<std::vector<std::uint8_t>> EncodePreviewGlb(const Store& store);

}
