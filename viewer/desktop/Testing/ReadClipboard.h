// SPDX-License-Identifier: BSD-3-Clause
// For tests of what is copied: reads what a user would paste.
#pragma once

#include <string>

namespace kdstream::testing
{

// Returns the X server's CLIPBOARD as UTF-8; empty if no program offers any within five seconds.
std::string ReadClipboard();

}
