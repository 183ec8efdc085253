// SPDX-License-Identifier: BSD-3-Clause
// Counts every allocation of a test program that has CountedMemory.cxx among its sources, on one
// thread.
#pragma once

#include <cstddef>

extern std::size_t liveBytes, peakBytes;
