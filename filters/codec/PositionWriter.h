// SPDX-License-Identifier: BSD-3-Clause
// Writes the positions of a piece's vertices as differences to what a predictor says.
#pragma once

#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PositionPredictor.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TriangleWalk.h"

#include <span>

namespace kdstream
{

// points: of each vertex. Chooses the mode that takes the fewest bits, by planes only where it may;
// deterministic.
template <class Predictor>
void WritePositions(SymbolWriter& symbols, const CoordinateGrid& grid,
  std::span<const WalkVertex> vertices, const typename Predictor::Point* points, bool mayUsePlanes);

}
