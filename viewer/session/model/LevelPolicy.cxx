// SPDX-License-Identifier: BSD-3-Clause
// Which level of detail to show at a zoom: step "choose" of the pipeline picture.
#include "viewer/session/model/LevelPolicy.h"

#include "viewer/session/model/ViewRefinement.h"

#include <algorithm>

namespace kdstream
{

std::vector<LevelFacts> LevelFactsOf(const ModelDescription& model)
{
  const double part = LightPartOf(model);
  std::vector<LevelFacts> facts;
  for (const auto& level : model.levels)
  {
    if (model.detail == ModelDetail::Preview && facts.size() > PreviewLevel(model))
    {
      break; // finer levels are not available
    }
    const double spacing = VertexSpacing(model.box, static_cast<double>(level.vertices));
    facts.push_back({ std::max(level.geometricError99, spacing * part), level.triangles });
  }
  return facts;
}

LevelPolicy::LevelPolicy(std::span<const LevelFacts> levels, const LevelPolicyOptions& options)
  : Options(options)
{
  const auto count = static_cast<unsigned>(levels.size());
  this->GeometricErrors.resize(count);
  double largest = 0;
  for (unsigned d = count; d-- > 0;)
  {
    largest = std::max(largest, levels[d].geometricError);
    this->GeometricErrors[d] = largest;
  }
  this->Preview = std::min(count - 1, previewDepth);
  this->Finest = this->Preview;
  while (
    this->Finest + 1 < count && levels[this->Finest + 1].triangles <= this->Options.triangleBudget)
  {
    ++this->Finest;
  }
}

unsigned LevelPolicy::Coarsest(double pointsPerUnit, double slack) const
{
  unsigned level = this->Preview;
  while (level < this->Finest &&
         this->Options.tolerance * slack < this->GeometricErrors[level] * pointsPerUnit)
  {
    ++level;
  }
  return level;
}

unsigned LevelPolicy::Choose(double pointsPerUnit, unsigned current) const
{
  const unsigned lenient = this->Coarsest(pointsPerUnit, this->Options.hysteresis);
  const unsigned strict = this->Coarsest(pointsPerUnit, 1 / this->Options.hysteresis);
  return current >= lenient && current <= strict ? current : this->Choose(pointsPerUnit);
}

}
