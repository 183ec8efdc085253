// SPDX-License-Identifier: BSD-3-Clause
// What mouse, keys and fingers do to a window.
#pragma once

#include <cstdint>
#include <string>

namespace kdstream
{

struct WindowEvent
{
  enum class Kind
  {
    Press,   // of `button`
    Release, // of `button`
    Move,    // of the mouse
    Wheel,   // by `notches`
    Pinch,   // on a trackpad, under the mouse: enlarges by `scale`
    Key,     // `key` is pressed, or repeats itself
    TouchBegin,
    TouchMove,
    TouchEnd
  };
  enum class Button
  {
    Left,
    Middle,
    Right
  };

  Kind kind = Kind::Move;
  double time = 0; // seconds of a steady clock
  double x = 0;    // pixels of the window from the left
  double y = 0;    // and from the top
  Button button = Button::Left;
  double notches = 0;      // away from the person: above 0
  double scale = 1;        // since the last event of the pinch, above 0
  std::string key;         // as X names it: "Left", "plus", "F1", "a"
  std::string text{};      // what the key writes, UTF-8; empty: nothing
  std::int64_t finger = 0; // of a touch
  bool shift = false, control = false;
};

}
