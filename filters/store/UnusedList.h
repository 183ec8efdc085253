// SPDX-License-Identifier: BSD-3-Clause
// The list of vertices that no triangle uses: the functions that both the reader and the writer of
// a store need. A part of the list is encoded as the only piece of a cloud with exact coordinates,
// whatever the model's grid is (doc/formats.md#unused-vertices).
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/core/Attribute.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <span>

namespace kdstream
{

// The piece id with which each part is encoded.
PieceId UnusedPartId();
CodecContext UnusedCodec(ScalarType scalarType);

// The number of vertices in each part but the last: 8192, or fewer if tuples are long. attributes:
// of the model.
std::uint32_t UnusedOfPart(std::span<const AttributeInfo> attributes);

// How many parts the model's list has; 0 if it has none.
std::uint64_t UnusedPartCount(const ModelDescription& model);

// How many vertices a part has. REQUIRES: part < UnusedPartCount(model).
std::uint64_t SizeOfUnusedPart(const ModelDescription& model, std::uint64_t part);

}
