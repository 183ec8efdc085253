// SPDX-License-Identifier: BSD-3-Clause
// A model's preview as a .glb that every viewer of glTF 2.0 can show, including those on phones for
// augmented reality: floats, and no extension.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// blob: of PreviewPiece; it may be hostile. In the file y is up, the front faces +z, the model
// stands on the origin, and units are metres; if the unit is not known, the model is one metre
// long. Deterministic. Errors: those of DecodePiece; NotFound for a cloud; LimitExceeded for a blob
// that is much larger than any preview, or if there is not enough memory.
Result<std::vector<std::uint8_t>> EncodePreviewGlb(
  const ModelDescription& model, std::span<const std::uint8_t> blob);

// Whether a preview can be made: the model has a picture, and is not a point cloud.
bool HasPreviewGlb(const ModelDescription& model);

}
