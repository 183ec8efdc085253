// SPDX-License-Identifier: BSD-3-Clause
// The list of vertices that no triangle uses: what reader and writer of a store agree on. A part of
// it is encoded as the only piece of a cloud with exact coordinates, whatever the model's grid is
// (doc/formats.md#unused-vertices).
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/core/Attribute.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <span>

namespace kdstream
{

// As which piece of which tree each part is encoded.
PieceId UnusedPartId();
CodecContext UnusedCodec(ScalarType scalarType);

// The vertices of each part but the last: 8192, or fewer of long tuples. attributes: of the model.
std::uint32_t UnusedOfPart(std::span<const AttributeInfo> attributes);

// How many parts the model's list has, from 0 on; 0 where it has none.
std::uint64_t UnusedPartCount(const ModelDescription& model);

// How many vertices a part has. REQUIRES: part < UnusedPartCount(model).
std::uint64_t SizeOfUnusedPart(const ModelDescription& model, std::uint64_t part);

}
