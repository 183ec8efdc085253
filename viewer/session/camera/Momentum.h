// SPDX-License-Identifier: BSD-3-Clause
// Turns a model by itself: for a moment after a finger has released it, or continuously. Step
// "navigate" of the pipeline picture.
#pragma once

#include "viewer/session/Camera.h"

#include <deque>
#include <optional>
#include <vector>

namespace kdstream
{

// Turns the model by drags like those of a finger, in steps of a fixed time, so that the same
// touches lead to the same view at any frame rate. Times are seconds of the clock of touches, and
// may have any values. No clock, no camera of its own.
class Momentum
{
public:
  // A finger goes from (x - dx, y - dy) to (x, y), in pixels.
  struct Drag
  {
    double x = 0, y = 0, dx = 0, dy = 0;
  };

  // One finger is down. Does nothing if it was down already.
  void Touch(double time);
  // The finger has turned the model by this number of pixels.
  void Follow(double time, double dx, double dy);
  // The finger is up, or another finger has come.
  void Forget() { this->Steps.clear(); }
  // The finger is released at (x, y): the model continues to turn, as fast as the finger was,
  // unless the finger had stopped, or its drag took no time.
  void LetGo(double time, double x, double y, double pixelRatio);
  bool TurnsOn() const { return this->Coasting.has_value(); }
  void Stop() { this->Coasting.reset(); }

  // Whether the model turns continuously, once in 24 seconds.
  void SetSpinning(bool spins);
  bool IsSpinning() const { return this->Spins; }

  // The drags that are due by that time; none if the model does not turn. Turning ends when it has
  // become slow, or when the clock has changed.
  std::vector<Drag> Advance(double time, double pixelRatio);
  // The drag for the spin since the last call. REQUIRES: IsSpinning(), a finite time.
  Drag Spin(double time, const Viewport& window);

private:
  struct Step
  {
    double time = 0, dx = 0, dy = 0;
  };
  // A finger at (x, y) that moves at a speed in pixels a second.
  struct Coast
  {
    double time = 0, x = 0, y = 0, speedX = 0, speedY = 0;
  };

  std::deque<Step> Steps; // the last ones of a finger that turns
  std::optional<Coast> Coasting;
  bool Spins = false;
  std::optional<double> LastSpin;
};

}
