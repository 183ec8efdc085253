// SPDX-License-Identifier: BSD-3-Clause
// Recordings: all inputs of a session and of its connection to a server, in order, with times: what
// the user did, and every byte that the server sent. If a recording is played again, it gives the
// same trace on any machine. This proves that the phone runs the same logic as the desktop.
//
// A recording is one file. Each input is a line of JSON, then its payload and a line's end:
//
//   {"t":0.25,"input":"touches","numbers":[1,640,360.5],"bytes":0}
//
//   t        seconds of a clock that runs from 0
//   input    what came, as below
//   numbers  its numbers
//   bytes    size of the payload after the line's end; if it is 0, nothing follows
//
//   input          numbers               payload
//   resize         width, height, ratio
//   touches        id, x, y of each
//   cancel
//   wheel          factor, x, y
//   rings          1-3
//   detail         0 by the view, 1 one level, 2 the original
//   budgets        triangles, bytes
//   turning        0 upright, 1 free
//   coast          1: the model turns on after a release, 0: it does not
//   home undo
//   select                               the model
//   back
//   models                               the answer to GET /api/models
//   opened                                              the connection is open
//   text                                 the message
//   frame                                the message
//   ended          1 = refused, else 0   why
//   fetched        status of HTTP        the body
//   not fetched                          why
//   tick hurry draw
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <string_view>
#include <vector>

namespace kdstream::testing
{

struct RecordedInput
{
  enum class Kind
  {
    Resize,
    Touches,
    CancelTouches,
    Wheel,
    Rings,
    Detail,
    Budgets,
    Turning,
    Coast,
    Home,
    Undo,
    Select,
    Back,
    Models,
    Opened,
    Text,
    Frame,
    Ended,
    Fetched,
    NotFetched,
    Tick,
    RetryNow,
    Draw
  };
  Kind kind = Kind::Draw;
  double time = 0;
  std::vector<double> numbers;
  std::string payload;
};

const char* NameOf(RecordedInput::Kind kind);

// An input in the format of a recording.
std::string FormatInput(const RecordedInput& input);

// Removes the first input from the front of `text`, and returns it. Errors: InvalidInput, naming
// what is wrong, also if the count of the numbers does not fit the kind.
Result<RecordedInput> TakeInput(std::string_view& text);

}
