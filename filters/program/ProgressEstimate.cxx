// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/ProgressEstimate.h"

namespace kdstream
{
namespace
{

// Shorter measurements are unreliable: the first part of a step is often faster or slower.
constexpr double leastSecondsOfStep = 1, leastOfStep = 0.02;
constexpr double leastSecondsOfWhole = 3, leastOfWhole = 0.05;

}

void ProgressEstimate::Run::Begin(double atFraction, double atSeconds)
{
  *this = { atFraction, atSeconds, atFraction, atSeconds };
}

bool ProgressEstimate::Run::IsTelling(double leastSeconds, double leastFraction) const
{
  return this->seconds - this->beginSeconds >= leastSeconds &&
         this->fraction - this->beginFraction >= leastFraction;
}

double ProgressEstimate::Run::Rate() const
{
  return (this->fraction - this->beginFraction) / (this->seconds - this->beginSeconds);
}

std::optional<double> ProgressEstimate::WholeFraction() const
{
  double before = 0;
  for (const StepShare& share : this->Shares)
  {
    if (share.step == this->Step)
    {
      return before + share.share * this->OfStep.fraction;
    }
    before += share.share;
  }
  return {};
}

void ProgressEstimate::Add(std::string_view step, double fraction, double seconds)
{
  if (step != this->Step || fraction < this->OfStep.fraction)
  {
    this->Step = step;
    this->OfStep.Begin(fraction, seconds);
  }
  this->OfStep.fraction = fraction;
  this->OfStep.seconds = seconds;
  const std::optional<double> whole = this->WholeFraction();
  if (whole && (!this->WholeKnown || *whole < this->OfWhole.fraction))
  {
    this->OfWhole.Begin(*whole, seconds);
  }
  this->WholeKnown = whole.has_value();
  this->OfWhole.fraction = whole.value_or(0);
  this->OfWhole.seconds = seconds;
}

std::optional<double> ProgressEstimate::Rate() const
{
  return this->OfStep.IsTelling(leastSecondsOfStep, leastOfStep)
           ? std::optional<double>(this->OfStep.Rate())
           : std::nullopt;
}

std::optional<ProgressEstimate::Time> ProgressEstimate::Left() const
{
  const Run& run = this->WholeKnown ? this->OfWhole : this->OfStep;
  const bool telling = this->WholeKnown ? run.IsTelling(leastSecondsOfWhole, leastOfWhole)
                                        : run.IsTelling(leastSecondsOfStep, leastOfStep);
  if (!telling || run.fraction >= 1)
  {
    return {};
  }
  return Time{ (1 - run.fraction) / run.Rate(), this->WholeKnown };
}

}
