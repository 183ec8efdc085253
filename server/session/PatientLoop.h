// SPDX-License-Identifier: BSD-3-Clause
// Processes many files, of which one may be on a disk that hangs: that one is abandoned, and the
// others are processed.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>

namespace kdstream
{

// Calls work(i) for each i below `count`, one after the other, on another thread. If a call takes
// longer than `patience`, it is abandoned with its thread, and late(i) is called on this thread;
// the others continue. The first exception of `work` is rethrown here. REQUIRES: work owns what it
// needs, because an abandoned call may end at any time, also after this function. Threads: one, and
// one for each abandoned call.
void ForEachPatiently(std::size_t count, std::chrono::milliseconds patience,
  std::function<void(std::size_t)> work, const std::function<void(std::size_t)>& late);

}
