// SPDX-License-Identifier: BSD-3-Clause
// One cut after the other, as a viewer shows them: for tests of what is drawn anew.
#pragma once

#include "Testing/Fixtures/Model.h"
#include "filters/core/drawing/SurfaceParts.h"

#include <cstdint>
#include <random>

namespace kdstream::fixtures
{

// A sequence of cuts of a model. Each differs from the one before by a few pieces, one in forty by
// many. The same for the same seed. The model must outlive it.
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
