// SPDX-License-Identifier: BSD-3-Clause
// Textures of levels, each from the next finer resolution's: part of step "encode" of the pipeline
// picture. They are made of the pieces that the store has, so all back ends give the same ones.
#pragma once

#include "filters/build/PieceTextures.h"
#include "filters/build/StepClock.h"
#include "filters/core/Execution.h"
#include "filters/store/StoreWriter.h"

#include <vector>

namespace kdstream
{

// How much of step "encode" is done before them: about, of the generated statue.
inline constexpr double encodedBeforeLevelTextures = 0.5;

// Makes the textures of all pieces of levels, fine to coarse, and writes them. boxes: of the tree's
// nodes, heap order. Memory: of each thread a piece with its tile in the making, and one finer
// piece. REQUIRES: all pieces are written, with textures of the original's.
// Errors: those of the writer and of `textures`; Cancelled.
Status WriteLevelTextures(const PieceTextures& textures, const std::vector<Box>& boxes,
  const ModelDescription& model, StoreWriter& writer, StepClock& clock, const Execution& execution);

}
