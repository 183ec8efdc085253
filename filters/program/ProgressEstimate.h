// SPDX-License-Identifier: BSD-3-Clause
// Estimates from progress reports how fast a step is and how long the work still takes: for the
// programs' progress lines (doc/cli.md#progress).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The share of the whole time that a step takes. All shares add up to 1.
struct StepShare
{
  std::string step;
  double share = 0;
};

// Estimates nothing until there is enough data. Has no clock of its own: times are seconds since
// any moment.
class ProgressEstimate
{
public:
  // shares: of the steps, in order, if they are known; otherwise only single steps are estimated.
  explicit ProgressEstimate(std::vector<StepShare> shares = {})
    : Shares(std::move(shares))
  {
  }

  // Reports that `fraction` (0-1) of the step is done. A step may begin with a part of it already
  // done. If the fraction decreases, the step begins again.
  void Add(std::string_view step, double fraction, double seconds);

  // The fraction of the step that is done per second, since its beginning.
  std::optional<double> Rate() const;
  struct Time
  {
    double seconds = 0; // above 0
    bool whole = false; // true: estimate for all steps; false: for this step
  };
  // Nothing at the end of the work.
  std::optional<Time> Left() const;

private:
  // A measurement: the fraction and the time at which it began, and the fraction reached.
  struct Run
  {
    double beginFraction = 0, beginSeconds = 0;
    double fraction = 0, seconds = 0;

    void Begin(double atFraction, double atSeconds);
    bool IsTelling(double leastSeconds, double leastFraction) const;
    double Rate() const;
  };

  // The progress of all steps; nothing for a step without a share.
  std::optional<double> WholeFraction() const;

  std::vector<StepShare> Shares;
  std::string Step;
  Run OfStep, OfWhole;
  bool WholeKnown = false;
};

}
