// SPDX-License-Identifier: BSD-3-Clause
// A sequence of cuts, as a viewer shows them, for tests of incremental drawing.
#pragma once

#include "Testing/Fixtures/Model.h"
#include "filters/core/drawing/SurfaceParts.h"

#include <cstdint>
#include <random>

namespace kdstream::fixtures
{

// A sequence of cuts of a model. Each differs from the previous one by a few pieces, and one in
// forty by many. It depends only on the model and the seed. REQUIRES: the model outlives it.
class CutWalk
{
public:
  CutWalk(const Model& model, std::uint32_t seed);

  const Cut& Now() const { return this->C; }
  void Step();

private:
  void Leap();

  const Model& M;
  std::mt19937 Random;
  Cut C{ {}, {} };
};

}
