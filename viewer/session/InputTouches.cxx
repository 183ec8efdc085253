// SPDX-License-Identifier: BSD-3-Clause
// Translates mouse and keys into touches: see InputTouches.h.
#include "viewer/session/InputTouches.h"

namespace kdstream
{
namespace
{

// In points of the screen:
constexpr double halfGap = 60; // from a pair's middle to each of its fingers
constexpr double keySlop = 10; // an arrow key drags by this first, more than a tap's slop;
constexpr double keyStep = 40; // then by this in addition

constexpr double tapSeconds = 0.05, betweenTaps = 0.1; // betweenTaps: from beginning to beginning

}

void AddTouches(const Pointer& pointer, double pixelRatio, std::vector<Touch>& touches)
{
  const auto& [id, x, y, isPair] = pointer;
  if (isPair)
  {
    const double gap = halfGap * pixelRatio;
    touches.push_back({ id, x - gap, y });
    touches.push_back({ id + 1, x + gap, y });
  }
  else
  {
    touches.push_back({ id, x, y });
  }
}

TouchFrame DragByKey(
  const Viewport& window, double right, double down, bool pans, double time, unsigned frame)
{
  TouchFrame touched{ time, {} };
  if (frame + 1 < dragFrames)
  {
    const double points = frame == 0 ? 0 : frame == 1 ? keySlop : keySlop + keyStep;
    const double way = points * window.pixelRatio;
    const double x = 0.5 * window.width + right * way;
    const double y = 0.5 * window.height + down * way;
    AddTouches({ pans ? -2 : -1, x, y, pans }, window.pixelRatio, touched.touches);
  }
  return touched;
}

TouchFrame TapByKey(const Viewport& window, double time, unsigned frame)
{
  const bool isDown = frame % tapFrames == 0;
  TouchFrame touched{ time + betweenTaps * (frame / tapFrames) + (isDown ? 0 : tapSeconds), {} };
  if (isDown)
  {
    AddTouches({ -1, 0.5 * window.width, 0.5 * window.height }, window.pixelRatio, touched.touches);
  }
  return touched;
}

}
