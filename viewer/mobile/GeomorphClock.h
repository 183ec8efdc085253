// SPDX-License-Identifier: BSD-3-Clause
// When a surface morphs from the one before it, and whether the device is fast enough for that.
#pragma once

#include <algorithm>

namespace kdstream
{

// Times are seconds of a steady clock.
class GeomorphClock
{
public:
  static constexpr double duration = 0.15;
  // If fewer pictures than this are drawn in that time, morphing is too slow for the device. Then
  // new vertices appear at once, for `rest` seconds, before morphing is tried again.
  static constexpr int fewestFrames = 5;
  static constexpr double rest = 10;

  bool MayBegin(double now) const { return now >= this->RestsUntil; }

  // Call this when the first picture of a surface that morphs has been drawn.
  void Begin(double now)
  {
    this->Began = now;
    this->Frames = 0;
  }

  // Returns the progress of the geomorph, 0 … 1, for a picture that is drawn now; slower at both
  // ends.
  double Share(double now)
  {
    const double part = std::clamp((now - this->Began) / duration, 0.0, 1.0);
    if (this->Frames >= 0 && part < 1.0)
    {
      ++this->Frames;
    }
    else if (this->Frames >= 0)
    {
      this->RestsUntil = this->Frames < fewestFrames ? now + rest : this->RestsUntil;
      this->Frames = -1;
    }
    return part * part * (3.0 - 2.0 * part);
  }

private:
  double Began = -duration, RestsUntil = 0;
  int Frames = -1; // drawn in the current geomorph
};

}
