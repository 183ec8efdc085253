// SPDX-License-Identifier: BSD-3-Clause
// Translates mouse and keys into touches, in the same way for every window: part of the first step
// of "navigate" in the pipeline picture. GestureRecognizer decides what the touches mean.
#pragma once

#include "viewer/session/Camera.h"
#include "viewer/session/GestureRecognizer.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// A finger or a mouse's button that is down.
struct Pointer
{
  std::int64_t id = 0; // id of its touch; the other touch of a pair has the next id
  double x = 0, y = 0; // pixels of the window
  bool isPair = false; // stands for two fingers, left and right of it: a mouse's right button
  bool operator==(const Pointer&) const = default;
};

// Appends the one or two touches of a pointer. pixelRatio: as in Viewport.
void AddTouches(const Pointer& pointer, double pixelRatio, std::vector<Touch>& touches);

// The factor of a key that zooms in; a key that zooms out divides by it.
inline constexpr double keyZoom = 1.25;

// An arrow key, as a finger that drags from the middle of the window by 50 points times `right` and
// `down` (-1 to 1); if `pans`, as two fingers. Its frames are 0 to dragFrames - 1.
inline constexpr unsigned dragFrames = 4;
TouchFrame DragByKey(
  const Viewport& window, double right, double down, bool pans, double time, unsigned frame);

// Taps in the middle of the window, in time and place close enough for a double tap: frames 0 to
// tapFrames - 1 are the first tap, and so on.
inline constexpr unsigned tapFrames = 2;
TouchFrame TapByKey(const Viewport& window, double time, unsigned frame);

}
