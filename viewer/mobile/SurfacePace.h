// SPDX-License-Identifier: BSD-3-Clause
// In which frames a surface is made of what has come, and drawn, so that none waits long.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace kdstream
{

// Spreads the work for arriving data over frames: decoding, making the surface, and uploading it to
// graphics memory are done in different frames. If much is shown, a phone takes long to make a
// surface for every part that arrives; this may take at most a third of the time, so that fingers
// are followed in between. Times are seconds of a steady clock.
class SurfacePace
{
public:
  // The most frames in a row that decode something and do not make a surface.
  static constexpr int mostPutOff = 2;
  // The next surface waits for twice the time that the last one took, and never longer.
  static constexpr double longestWait = 1;

  // Whether another surface may be made or drawn now. coming: whether more of it is on its way.
  bool MayDraw(bool coming, double now) const { return !coming || now >= this->Next; }

  // Call this once in each frame that has no new surface to draw. loaded: number of blobs that have
  // arrived so far. True if the surface is better made in the next frame, because this one has
  // decoded.
  bool PutsOff(std::uint64_t loaded)
  {
    const bool arrived = std::exchange(this->Loaded, loaded) != loaded;
    this->FramesPutOff = arrived ? this->FramesPutOff + 1 : 0;
    return arrived && this->FramesPutOff <= mostPutOff;
  }
  // Whether the last frame did.
  bool IsPuttingOff() const { return this->FramesPutOff > 0; }

  // A surface was made, which a later frame draws; 0 where it is drawn in this frame.
  void Made(double seconds)
  {
    this->FramesPutOff = 0;
    this->Making = seconds;
  }
  // Seconds that making the surface took.
  double MakingSeconds() const { return this->Making; }

  // A surface, or what paints it, was drawn until now; seconds: with making it.
  void Drawn(double now, double seconds) { this->Next = now + std::min(2 * seconds, longestWait); }

private:
  double Next = 0;
  double Making = 0;
  std::uint64_t Loaded = 0;
  int FramesPutOff = 0;
};

}
