// SPDX-License-Identifier: BSD-3-Clause
// Does something with each of many files, of which one may be on a disk that hangs: that one is
// left, and the others are done.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>

namespace kdstream
{

// Calls work(i) for each i below `count`, one after the other, from another thread. Where one takes
// longer than `patience` it is left alone with its thread, and late(i) is called, from this thread;
// the others go on. What work throws is thrown here, by the first that does. REQUIRES: work holds
// what it needs: what is left alone may end at any time, after this too. Threads: one, and one for
// each that is left alone.
void ForEachPatiently(std::size_t count, std::chrono::milliseconds patience,
  std::function<void(std::size_t)> work, const std::function<void(std::size_t)>& late);

}
