// Which level of detail to show at a zoom: step "choose" of the README's picture.
#include "viewer/session/LevelPolicy.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

std::vector<double> EstimateDeviations(
  std::span<const float> preview, std::span<const double> largest)
{
  constexpr double fall = 0.58; // from one level to the next finer one
  double sum = 0;
  for (const float deviation : preview)
  {
    sum += double{ deviation } * double{ deviation };
  }
  const double count = preview.empty() ? 1 : static_cast<double>(preview.size());
  double typical = 2 * std::sqrt(sum / count);
  std::vector<double> deviations(largest.begin(), largest.end());
  for (std::size_t d = LevelPolicy::previewDepth; d < deviations.size(); ++d)
  {
    deviations[d] = std::min(deviations[d], typical);
    typical *= fall;
  }
  return deviations;
}

LevelPolicy::LevelPolicy(std::span<const LevelFacts> levels, const LevelPolicyOptions& options)
  : Options(options)
{
  const auto count = static_cast<unsigned>(levels.size());
  this->Deviations.resize(count);
  double largest = 0;
  for (unsigned d = count; d-- > 0;)
  {
    largest = std::max(largest, levels[d].deviation);
    this->Deviations[d] = largest;
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
  while (
    level<this->Finest&& this->Deviations[level] * pointsPerUnit> this->Options.tolerance * slack)
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
