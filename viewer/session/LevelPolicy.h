// Which level of detail to show at a zoom: step "choose" of the README's picture (paper
// section 5.2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What the policy has to know of a level.
struct LevelFacts
{
  double deviation = 0; // typical of its vertices, model units
  std::uint64_t triangles = 0;
};

struct LevelPolicyOptions
{
  // A level is fine enough where its deviation is at most this many points (pixels / pixel ratio)
  // on the screen. Above 0.
  double tolerance = 1;
  // A level once chosen stays while the tolerance divided or multiplied by this would still choose
  // it: zooming to and fro around a border does not flicker. At least 1.
  double hysteresis = 1.25;
  // No level above the preview that has more triangles is chosen: what memory and frame rate allow.
  std::uint64_t triangleBudget = 2'000'000;
};

// The typical deviation of every level: twice the root mean square over its vertices, which about
// 95 % of them do not exceed. (The largest will not do: one vertex in a far corner of a scan keeps
// it up through all levels.)
//
// That of the preview is measured on the deviations of its vertices; a finer level's is estimated
// as 0.58 of the next coarser one's (measured on the Stanford dragon: 0.57 to 0.62 from level 11 to
// 16; half for a smooth surface, where it goes with the square of the distance between vertices),
// and is never above the level's largest one. preview: deviations of the vertices of level min(L,
// 11). largest: of each level, 0 … L. O(vertices).
std::vector<double> EstimateDeviations(
  std::span<const float> preview, std::span<const double> largest);

// Chooses among the levels preview … L of one model: the coarsest whose deviation is small enough
// on the screen; where none is, the finest that the budget allows. The preview itself is always
// allowed. Finer zoom never gives a coarser level. Deviations that do not fall towards the finer
// levels are taken as the maximum over it and all finer ones. O(levels) a question; no state.
class LevelPolicy
{
public:
  static constexpr unsigned previewDepth = 11;

  // levels: 0 … L, at least one.
  explicit LevelPolicy(std::span<const LevelFacts> levels, const LevelPolicyOptions& options = {});

  // min(L, 11).
  unsigned PreviewLevel() const { return this->Preview; }

  // The level for a scale of `pointsPerUnit` points a model unit in the focal plane, without
  // history.
  unsigned Choose(double pointsPerUnit) const { return this->Coarsest(pointsPerUnit, 1); }
  // The same, for a viewer that aims at `current` now.
  unsigned Choose(double pointsPerUnit, unsigned current) const;

private:
  unsigned Coarsest(double pointsPerUnit, double slack) const;

  LevelPolicyOptions Options;
  std::vector<double> Deviations; // of levels 0 … L, falling
  unsigned Preview = 0;
  unsigned Finest = 0; // that the budget allows
};

}
