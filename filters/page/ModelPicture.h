// SPDX-License-Identifier: BSD-3-Clause
// The picture of a model that is shown for a link: its preview in the first view, as a JPEG. It is
// drawn by the processor, so that servers need no graphics card. It looks the same as in the
// viewers (viewer/session/appearance/SceneAppearance.h), except for ambient occlusion.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

inline constexpr unsigned pictureWidth = 1200, pictureHeight = 630; // pixels

// The piece that is drawn. REQUIRES: model.HasLevels().
PieceId PreviewPiece(const ModelDescription& model);

// Decodes the blob of this piece, which may be hostile. Errors: those of DecodePiece; LimitExceeded
// for a blob that is much larger than any preview.
Result<Piece> DecodePreview(const ModelDescription& model, std::span<const std::uint8_t> blob);

// blob: of this piece; it may be hostile. O(blob + samples); 30 MB of memory, and the piece. If
// triangles cover the picture more than a hundred times, only a part of them is drawn: so time is
// bounded. Errors: those of DecodePreview; LimitExceeded if there is not enough memory.
Result<std::vector<std::uint8_t>> DrawModelPicture(
  const ModelDescription& model, std::span<const std::uint8_t> blob);

// Whether the model can be drawn: it has a preview that is not too large.
bool HasPicture(const ModelDescription& model);

}
