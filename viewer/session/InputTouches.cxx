// SPDX-License-Identifier: BSD-3-Clause
// Touches that stand for a mouse and for keys.
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

std::vector<TouchFrame> DragByKey(
  const Viewport& window, double right, double down, bool pans, double time)
{
  std::vector<TouchFrame> frames;
  for (const double points : { 0.0, keySlop, keySlop + keyStep })
  {
    const double way = points * window.pixelRatio;
    const double x = 0.5 * window.width + right * way;
    const double y = 0.5 * window.height + down * way;
    TouchFrame& frame = frames.emplace_back(TouchFrame{ time, {} });
    AddTouches({ pans ? -2 : -1, x, y, pans }, window.pixelRatio, frame.touches);
  }
  frames.push_back({ time, {} });
  return frames;
}

std::vector<TouchFrame> TapByKey(const Viewport& window, unsigned times, double time)
{
  std::vector<TouchFrame> frames;
  for (unsigned tap = 0; tap < times; ++tap)
  {
    const double begin = time + betweenTaps * tap;
    TouchFrame& frame = frames.emplace_back(TouchFrame{ begin, {} });
    AddTouches({ -1, 0.5 * window.width, 0.5 * window.height }, window.pixelRatio, frame.touches);
    frames.push_back({ begin + tapSeconds, {} });
  }
  return frames;
}

}
