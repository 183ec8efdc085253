// SPDX-License-Identifier: BSD-3-Clause
// A model that turns by itself: see Momentum.h.
#include "viewer/session/camera/Momentum.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{
// Coasting: each step is slower than the one before. In all, the model turns about as far as the
// finger would turn it in a fifth of a second.
constexpr double coastStep = 1.0 / 120, coastSlowing = 0.96;
constexpr double slowestCoast = 6;    // points a second
constexpr double fastestCoast = 4000; // points a second
constexpr double speedSeconds = 0.1;  // a finger's speed is measured over this last time
constexpr std::size_t mostSteps = 64;
constexpr double restSeconds = 0.05; // a finger that did not move for this time is at rest
}

void Momentum::Touch(double time)
{
  if (this->Steps.empty())
  {
    this->Steps.push_back({ time, 0, 0 }); // the next step begins here
  }
}

void Momentum::Follow(double time, double dx, double dy)
{
  this->Steps.push_back({ time, dx, dy });
  if (this->Steps.size() > mostSteps)
  {
    this->Steps.pop_front();
  }
}

void Momentum::LetGo(double time, double x, double y, double pixelRatio)
{
  // Removes steps that ended too long ago. The first step that is left may have begun earlier: on a
  // slow device one step may be the whole drag.
  std::deque<Step>& steps = this->Steps;
  while (steps.size() > 1 && !(steps[1].time >= time - speedSeconds))
  {
    steps.pop_front();
  }
  if (steps.size() < 2 || time - steps.back().time > restSeconds)
  {
    return;
  }
  const double seconds = time - steps.front().time;
  if (!(seconds > coastStep))
  {
    return; // a drag by keys takes no time
  }
  Coast coast{ time, x, y, 0, 0 };
  for (std::size_t i = 1; i < steps.size(); ++i)
  {
    coast.speedX += steps[i].dx / seconds;
    coast.speedY += steps[i].dy / seconds;
  }
  const double speed =
    std::sqrt(coast.speedX * coast.speedX + coast.speedY * coast.speedY) / pixelRatio;
  const double slower = speed > fastestCoast ? fastestCoast / speed : 1;
  coast.speedX *= slower;
  coast.speedY *= slower;
  this->Coasting = coast;
}

void Momentum::SetSpinning(bool spins)
{
  this->Spins = spins;
  this->LastSpin.reset();
}

Momentum::Drag Momentum::Spin(double time, const Viewport& window)
{
  constexpr double longestStep = 0.1;       // after a pause the model continues where it was
  constexpr double sidesPerSecond = 0.1309; // sides of the window; 2 sides are a radian
  const double seconds = this->LastSpin ? std::clamp(time - *this->LastSpin, 0.0, longestStep) : 0;
  this->LastSpin = time;
  const double pixels = sidesPerSecond * seconds * std::min(window.width, window.height);
  return { 0.5 * window.width + pixels, 0.5 * window.height, pixels, 0 };
}

std::vector<Momentum::Drag> Momentum::Advance(double time, double pixelRatio)
{
  std::vector<Drag> drags;
  if (this->Coasting && !(time >= this->Coasting->time - 1))
  {
    this->Coasting.reset(); // the time is of another clock
  }
  const double slowest = slowestCoast * pixelRatio;
  while (this->Coasting && this->Coasting->time + coastStep <= time)
  {
    Coast& coast = *this->Coasting;
    coast.time += coastStep;
    drags.push_back({ coast.x, coast.y, coast.speedX * coastStep, coast.speedY * coastStep });
    coast.speedX *= coastSlowing;
    coast.speedY *= coastSlowing;
    if (coast.speedX * coast.speedX + coast.speedY * coast.speedY < slowest * slowest)
    {
      this->Coasting.reset();
    }
  }
  return drags;
}

}
