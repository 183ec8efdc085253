// SPDX-License-Identifier: BSD-3-Clause
// Records a walk on a line of 50 kB/s, each answer drawn for itself: zooms that are cancelled, a
// tap while much is in flight, and budgets that are met, made smaller and larger again.
#pragma once

#include <string>

namespace kdstream::testing
{

// Around the painted torus, over the stream or by GET. Writes FILE.recording and FILE.trace. False,
// and why on stderr, where it did not get through what it is for, or a surface had a hole.
bool WalkSlowly(bool stream, const std::string& file);

}
