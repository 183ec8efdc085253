// SPDX-License-Identifier: BSD-3-Clause
// Recorded sessions: what a person did, as JSON lines, to be played again. Step "replay" of the
// README's picture.
//
//   {"t":0.25,"touches":[{"id":1,"x":640,"y":360}]}   the fingers on the screen at that time, all
//   of them
//   {"wait":"idle"}                                   until everything that was asked for has come
//   {"screenshot":"NAME.png"}                         the picture as it is now
//   {"select":"MODEL"}                                choose a model; the one that is chosen
//   already: full screen
//   {"turning":"upright"}                             how fingers turn the model from here on:
//   upright or free, which it is before
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/GestureRecognizer.h"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct SessionStep
{
  enum class Kind
  {
    Touches,
    WaitForIdle,
    Screenshot,
    Select,
    Turning
  };
  Kind kind = Kind::WaitForIdle;
  TouchFrame frame; // of Touches
  std::string name; // file of Screenshot, model of Select, "upright" or "free" of Turning
  bool operator==(const SessionStep&) const = default;
};

// Reads a session file's content; empty lines are skipped. O(size).
// check: what a player has against a step, which is told before it plays any.
// Errors: InvalidInput naming the line and what is wrong in it; unknown keys are errors, and what
// `check` says.
Result<std::vector<SessionStep>> ParseSession(
  std::string_view text, const std::function<Status(const SessionStep&)>& check = {});

// The step as one line, without the line's end. Parsing it gives the same step again, bit for bit.
std::string FormatSessionStep(const SessionStep& step);

}
