// SPDX-License-Identifier: BSD-3-Clause
// Makes the textures of levels, each from the textures of the next finer resolution: part of step
// "encode" of the pipeline picture. They are made from the pieces in the store, so all back ends
// make the same ones.
#pragma once

#include "filters/build/PieceTextures.h"
#include "filters/build/StepClock.h"
#include "filters/core/Execution.h"
#include "filters/store/StoreWriter.h"

#include <vector>

namespace kdstream
{

// The share of step "encode" that is done before them: about right for the generated statue.
inline constexpr double encodedBeforeLevelTextures = 0.5;

// Makes the textures of all pieces of levels, fine to coarse, and writes them. boxes: of the tree's
// nodes, in heap order. Memory: for each thread one piece, the tile that is being made, and one
// finer piece. REQUIRES: all pieces are written, with the textures of the original.
// Errors: those of the writer and of `textures`; Cancelled.
Status WriteLevelTextures(const PieceTextures& textures, const std::vector<Box>& boxes,
  const ModelDescription& model, StoreWriter& writer, StepClock& clock, const Execution& execution);

}
