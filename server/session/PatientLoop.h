// SPDX-License-Identifier: BSD-3-Clause
// Processes many files, one of which may be on a disk that hangs: that file is abandoned, and the
// others are processed.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>

namespace kdstream
{

// Calls work(i) for each i below `count`, one after the other, on another thread. If a call takes
// longer than `patience`, the call is abandoned together with its thread, late(i) is called on this
// thread, and the other calls continue. The first exception of `work` is rethrown here. REQUIRES:
// work owns what it needs, because an abandoned call may end at any time, even after this function.
// Threads: one, and one more for each abandoned call.
void ForEachPatiently(std::size_t count, std::chrono::milliseconds patience,
  std::function<void(std::size_t)> work, const std::function<void(std::size_t)>& late);

}
