// SPDX-License-Identifier: BSD-3-Clause
// Records a walk on a connection of 50 kB/s, with a frame for each answer: zooms that are
// cancelled, a tap while much is in flight, and budgets that are reached, lowered and raised again.
#pragma once

#include <string>

namespace kdstream::testing
{

// The walk is around the coloured torus, over the stream or by GET. Writes FILE.recording and
// FILE.trace. False, with the reason on stderr, if the walk did not get into all the situations
// that it is for, or if a surface had a hole.
bool WalkSlowly(bool stream, const std::string& file);

}
