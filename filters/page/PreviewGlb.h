// SPDX-License-Identifier: BSD-3-Clause
// A model's preview as a .glb that every viewer of glTF 2.0 shows, those of phones for augmented
// reality too: floats, and no extension.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// blob: of PreviewPiece; it may be hostile. y is up, the front looks to +z, the model stands on the
// origin, in metres; one whose unit is not known is a metre long. Deterministic. Errors: those of
// DecodePiece; NotFound for a cloud; LimitExceeded for a blob that is much larger than previews
// are, and for lack of memory.
Result<std::vector<std::uint8_t>> EncodePreviewGlb(
  const ModelDescription& model, std::span<const std::uint8_t> blob);

// Whether the model may have one: it has a picture, and is not a point cloud.
bool HasPreviewGlb(const ModelDescription& model);

}
