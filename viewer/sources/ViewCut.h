// SPDX-License-Identifier: BSD-3-Clause
// Which pieces a camera needs: all at once, chosen in the same way as in viewers (ViewRefinement).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/PieceSource.h"
#include "viewer/session/appearance/SceneRules.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

struct ViewDemand
{
  SceneCamera camera;
  int width = 800, height = 600;       // pixels
  double tolerance = 1;                // pixels: a smaller error counts as invisible; above 0
  std::uint64_t triangles = 2'000'000; // approximate maximum; the cut becomes coarser to keep it
};

// The pieces to show in place of the preview. Reads the necessary pages of the tree. Errors: those
// of CheckCamera and of the source; Unsupported for a model without levels; Cancelled. Reports the
// step "view".
Result<std::vector<PieceId>> ChooseByView(
  const PieceSource& source, const ViewDemand& demand, const Execution& execution = {});

}
