// SPDX-License-Identifier: BSD-3-Clause
// A model that turns by itself: on for a moment, when a finger has let it go, or on and on. Step
// "look" of the pipeline picture.
#pragma once

#include "viewer/session/Camera.h"

#include <deque>
#include <optional>
#include <vector>

namespace kdstream
{

// What turns it are drags, as of a finger: in steps of a fixed time, so that the same touches lead
// to the same view whatever the frames are. Times are seconds of the clock of touches; any may be
// given. No clock, no camera of its own.
class Momentum
{
public:
  // A finger goes from (x - dx, y - dy) to (x, y), pixels.
  struct Drag
  {
    double x = 0, y = 0, dx = 0, dy = 0;
  };

  // One finger is down. Nothing where it was already.
  void Touch(double time);
  // It has turned the model, by so many pixels.
  void Follow(double time, double dx, double dy);
  // It has gone, or is not the only one any more.
  void Forget() { this->Steps.clear(); }
  // It lets go at (x, y): the model turns on, as fast as the finger was, unless that had come to
  // rest or took no time.
  void LetGo(double time, double x, double y, double pixelRatio);
  bool TurnsOn() const { return this->Coasting.has_value(); }
  void Stop() { this->Coasting.reset(); }

  // On and on, once in 24 seconds.
  void SetSpinning(bool spins);
  bool IsSpinning() const { return this->Spins; }

  // What has become due by that time: of turning on, none where nothing has. It ends where it has
  // become slow, and where the clock is another one.
  std::vector<Drag> Advance(double time, double pixelRatio);
  // Of spinning, since the last call. REQUIRES: IsSpinning(), a finite time.
  Drag Spin(double time, const Viewport& window);

private:
  struct Step
  {
    double time = 0, dx = 0, dy = 0;
  };
  // Pixels a second that a finger at (x, y) would go.
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
