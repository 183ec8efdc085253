// SPDX-License-Identifier: BSD-3-Clause
// What a person would paste: for tests of what is copied.
#pragma once

#include <string>

namespace kdstream::testing
{

// The X server's CLIPBOARD as UTF-8; empty if no program offers any within five seconds.
std::string ReadClipboard();

}
