// SPDX-License-Identifier: BSD-3-Clause
// Decides which pictures have ambient occlusion (OcclusionShaders.h): all on a fast device; on a
// slow one only those of a view at rest.
#pragma once

namespace kdstream
{

// Times are seconds of a steady clock.
class OcclusionClock
{
public:
  static constexpr double slowFrame = 0.045;
  static constexpr int slowFrames = 3; // this number of slow frames in a row: the device is slow
  static constexpr double pause = 10;  // seconds until occlusion is tried again
  static constexpr double stillness = 0.25;

  // Whether a picture that is drawn now has it. moves: it differs from the last picture.
  bool Has(bool moves, double now)
  {
    this->Moves = moves;
    if (moves)
    {
      this->LastMove = now;
    }
    return now >= this->PausesUntil || now - this->LastMove >= stillness;
  }

  // A picture was shown on the screen. seconds: the time that this picture took, if that is known;
  // otherwise, if pictures follow each other directly, the time since the one before. Waiting for
  // new surfaces does not count.
  void Drawn(bool occluded, double seconds, double now)
  {
    if (!this->Moves || !occluded)
    {
      return;
    }
    this->Slow = seconds > slowFrame ? this->Slow + 1 : 0;
    if (this->Slow >= slowFrames)
    {
      this->Slow = 0;
      this->PausesUntil = now + pause;
    }
  }

private:
  double LastMove = -1e9, PausesUntil = -1e9;
  bool Moves = false;
  int Slow = 0;
};

}
