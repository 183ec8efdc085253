// SPDX-License-Identifier: BSD-3-Clause
// Touches in place of a mouse and of keys.
#include "viewer/session/InputTouches.h"

namespace kdstream
{
namespace
{

// In points of the screen:
constexpr double halfGap = 60; // from a pair's middle to each of its fingers
constexpr double keySlop = 10; // that an arrow key drags by first, more than a tap's slop,
constexpr double keyStep = 40; // and then

constexpr double tapSeconds = 0.05, betweenTaps = 0.1; // from one's beginning to the next one's

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
