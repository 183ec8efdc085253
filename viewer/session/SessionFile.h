// SPDX-License-Identifier: BSD-3-Clause
// Recorded sessions: what a user did, as JSON lines, to be played again. Step "replay" of the
// pipeline picture.
//
//   {"t":0.25,"touches":[{"id":1,"x":640,"y":360}]}
//       the fingers on the screen at that time, all of them
//   {"wait":"idle"}             until everything that was requested has arrived
//   {"screenshot":"NAME.png"}   the picture as it is now
//   {"select":"MODEL"}          choose a model; if it is chosen already: full screen
//   {"zoom":1.25,"x":640,"y":360}
//       a wheel enlarges by this factor about that pixel
//   {"go":"home"}               the first view again; "undo": the view before the last jump;
//                               "back": out of full screen
//   {"side":"front"}            from there: front, back, left, right, top or bottom
//   {"link":"model=…"}          the view of a link (ViewLink.h), without its colours and light
//   {"tool":"measure"}          what fingers do from here on: measure, section, light,
//                               second light, or none of these (the default)
//   {"section":"side"}          a plane through the middle, across the direction "front", "side" or
//                               "above", "x", "y" or "z", or "view"; "flip": cuts away the other
//                               side; "off"
//   {"depth":0.4}               the part of the model that is cut away, 0-1
//   {"lamps":"…"}               light as in a link (ViewLink.h); "standard"
//   {"turning":"upright"}       how fingers turn the model from here on: upright, or free (the
//                               default)
//   {"detail":"level"}          view, level or full from here on
//   {"rings":2}                 of the next regions
//   {"triangles":300000,"memory":150000000}
//       budgets of what is shown, from here on: triangles, and bytes for them
//   {"colours":"partition"}     own, none, partition, resolution, or by:NAME, the array of that
//                               name, from here on: as FormatColors of appearance/Coloring.h has it
//   {"light":"plain"}           relief or plain from here on
//   {"boxes":"on"}              of the region's partitions; "off"
//   {"window":[1280,720],"ratio":1}
//       how many pixels the window has from here on, and how many of them make a point
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/Camera.h"
#include "viewer/session/GestureRecognizer.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

class ViewerSession;

struct SessionStep
{
  enum class Kind
  {
    Touches,
    WaitForIdle,
    Screenshot,
    Select,
    Zoom,
    Go,
    Side,
    Link,
    Tool,
    Section,
    Depth,
    Lights,
    Turning,
    Detail,
    Rings,
    Budgets,
    Colors,
    Light,
    Boxes,
    Window
  };
  Kind kind = Kind::WaitForIdle;
  TouchFrame frame; // of Touches
  // File of Screenshot, model of Select, text of Link and Lights; word of Go, Side, Tool, Section,
  // Turning, Detail, Colors, Light and Boxes.
  std::string name{};
  double factor = 1; // of Zoom, above 0; of Depth, 0-1
  double x = 0, y = 0;
  unsigned rings = 1;                      // 1-3
  Viewport window{};                       // sides of 1 to largestSide pixels, ratio from 1/8 to 8
  std::uint64_t triangles = 0, memory = 0; // of Budgets, above 0

  static constexpr int largestSide = 8192;
  bool operator==(const SessionStep&) const = default;
};

// Whether the step does nothing without an open model: touches, zooms, jumps, a section.
bool NeedsModel(const SessionStep& step);

// Reads a session file's content; empty lines are skipped. O(size). check: returns an error for a
// step that the player cannot play; it is called for all steps before any is played. Errors:
// InvalidInput, naming the line and what is wrong in it, also for unknown keys and for errors of
// `check`.
Result<std::vector<SessionStep>> ParseSession(
  std::string_view text, const std::function<Status(const SessionStep&)>& check = {});

// Applies a recorded step to the session. Does nothing for WaitForIdle and Screenshot, which the
// player handles, and for Colors, Light and Boxes, which the scene handles. Errors: those of
// SelectModel.
Status Perform(const SessionStep& step, ViewerSession& session);

// The step as one line, without the line's end. Parsing it gives the same step again, bit for bit.
std::string FormatSessionStep(const SessionStep& step);

}
