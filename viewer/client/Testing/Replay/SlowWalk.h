// SPDX-License-Identifier: BSD-3-Clause
// Records a walk on a line of 50 kB/s, each answer drawn separately: zooms that are cancelled, a
// tap while much is in flight, and budgets that are reached, lowered and raised again.
#pragma once

#include <string>

namespace kdstream::testing
{

// Around the coloured torus, over the stream or by GET. Writes FILE.recording and FILE.trace.
// False, with the reason on stderr, if it did not reach all of its situations, or if a surface had
// a hole.
bool WalkSlowly(bool stream, const std::string& file);

}
