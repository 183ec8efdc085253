// SPDX-License-Identifier: BSD-3-Clause
// Events of a window: what the user does with mouse, keys and fingers.
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
    Pinch,   // on a trackpad, at the mouse's place: magnifies by `scale`
    Key,     // `key` is pressed, or repeats
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
  double notches = 0;      // above 0: away from the user
  double scale = 1;        // since the last event of the pinch, above 0
  std::string key;         // as X names it: "Left", "plus", "F1", "a"
  std::string text{};      // the text that the key types, UTF-8; may be empty
  std::int64_t finger = 0; // number of the finger of a touch
  bool shift = false, control = false;
};

}
