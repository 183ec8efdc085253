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

// What the policy has to know of a level.
struct LevelFacts
{
  double geometricError = 0; // that 99 of 100 of its vertices do not exceed, model units
  std::uint64_t triangles = 0;
};
// Facts about the available levels of a model, 0 first. Light and texture suffer before the shape
// does (LightPartOf). The vertices of a level are assumed to be spread over half the surface of the
// box.
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
  // The same, for a viewer that aims at `current` now.
  unsigned Choose(double pointsPerUnit, unsigned current) const;

private:
  unsigned Coarsest(double pointsPerUnit, double slack) const;

  LevelPolicyOptions Options;
  std::vector<double> GeometricErrors; // of levels 0 … L, falling
  unsigned Preview = 0;
  unsigned Finest = 0; // the finest level that the budget allows
};

}
