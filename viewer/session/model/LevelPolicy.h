// SPDX-License-Identifier: BSD-3-Clause
// Chooses the level of detail for a zoom: step "choose" of the pipeline picture (paper section
// 5.2).
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/session/SessionOptions.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What the policy must know about a level.
struct LevelFacts
{
  double geometricError = 0; // 99 of 100 of its vertices do not exceed it, model units
  std::uint64_t triangles = 0;
};
// Facts about the available levels of a model, level 0 first. The error of a level is at least what
// light and texture need, because they suffer before the shape does (LightPartOf); for this, the
// vertices are assumed to be spread over half the surface of the box.
std::vector<LevelFacts> LevelFactsOf(const ModelDescription& model);

// Chooses among the levels preview … L of one model: the coarsest whose geometric error is small
// enough on the screen; if there is none, the finest that the budget allows. The preview itself is
// always allowed. Finer zoom never gives a coarser level. If errors do not decrease towards finer
// levels, each counts as the maximum of its level and all finer ones. O(levels) a call; no state.
class LevelPolicy
{
public:
  static constexpr unsigned previewDepth = 11;

  // levels: 0 … L, at least one.
  explicit LevelPolicy(std::span<const LevelFacts> levels, const LevelPolicyOptions& options = {});

  // min(L, 11).
  unsigned PreviewLevel() const { return this->Preview; }

  // The level for a scale of `pointsPerUnit` points of the screen for one model unit in the focal
  // plane, without history.
  unsigned Choose(double pointsPerUnit) const { return this->Coarsest(pointsPerUnit, 1); }
  // The same with hysteresis, for a viewer whose level is `current`.
  unsigned Choose(double pointsPerUnit, unsigned current) const;

private:
  unsigned Coarsest(double pointsPerUnit, double slack) const;

  LevelPolicyOptions Options;
  std::vector<double> GeometricErrors; // of levels 0 … L, falling
  unsigned Preview = 0;
  unsigned Finest = 0; // the finest level that the budget allows
};

}
