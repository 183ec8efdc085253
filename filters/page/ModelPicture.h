// SPDX-License-Identifier: BSD-3-Clause
// The picture of a model that a link shows: its preview in the first view, as a JPEG. Drawn by the
// processor, so that servers need no graphics. It looks like the viewers'
// (viewer/session/appearance/SceneAppearance.h), but for ambient occlusion.
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

// Decodes its blob, which may be hostile. Errors: those of DecodePiece; LimitExceeded for a blob
// that is much larger than previews are.
Result<Piece> DecodePreview(const ModelDescription& model, std::span<const std::uint8_t> blob);

// blob: of that piece; it may be hostile. O(blob + samples); 30 MB of memory, and the piece. What
// covers the picture more than a hundred times is drawn in part: time is bounded. Errors: those of
// DecodePreview; LimitExceeded for lack of memory.
Result<std::vector<std::uint8_t>> DrawModelPicture(
  const ModelDescription& model, std::span<const std::uint8_t> blob);

// Whether it can be drawn: it has a preview, which is not too large.
bool HasPicture(const ModelDescription& model);

}
