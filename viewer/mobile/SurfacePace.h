// SPDX-License-Identifier: BSD-3-Clause
// Decides in which frames a surface is made from arrived data, and drawn, so that no frame takes
// long.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace kdstream
{

// Spreads the work for arriving data over frames: decoding, making the surface, and uploading it to
// graphics memory are done in different frames. If much is shown, a phone takes long to make a new
// surface for each part that arrives. So this work gets at most a third of the time; in the rest,
// the picture follows the fingers. Times are seconds of a steady clock.
class SurfacePace
{
public:
  // The maximum number of consecutive frames that decode something and do not make a surface.
  static constexpr int mostPutOff = 2;
  // The next surface waits for twice the time that the last one took, but never longer than this.
  static constexpr double longestWait = 1;

  // Whether another surface may be made or drawn now. coming: whether more of the surface is in
  // flight.
  bool MayDraw(bool coming, double now) const { return !coming || now >= this->Next; }

  // Call this once in each frame that has no new surface to draw. loaded: number of blobs that have
  // arrived so far. Returns true if the surface should be made in the next frame, because this
  // frame has decoded something.
  bool PutsOff(std::uint64_t loaded)
  {
    const bool arrived = std::exchange(this->Loaded, loaded) != loaded;
    this->FramesPutOff = arrived ? this->FramesPutOff + 1 : 0;
    return arrived && this->FramesPutOff <= mostPutOff;
  }
  // Whether blobs arrived in the last frame, and the surface must still be made from them.
  bool IsPuttingOff() const { return this->FramesPutOff > 0; }

  // Call this when a surface was made that a later frame will draw. seconds: the time to make it; 0
  // if this frame draws it.
  void Made(double seconds)
  {
    this->FramesPutOff = 0;
    this->Making = seconds;
  }
  // Seconds that making the surface took.
  double MakingSeconds() const { return this->Making; }

  // Call this when a surface or its textures were drawn, at time `now`. seconds: the time for this,
  // and for making the surface.
  void Drawn(double now, double seconds) { this->Next = now + std::min(2 * seconds, longestWait); }

private:
  double Next = 0;
  double Making = 0;
  std::uint64_t Loaded = 0;
  int FramesPutOff = 0;
};

}
