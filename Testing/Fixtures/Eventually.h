// SPDX-License-Identifier: BSD-3-Clause
// Waits for another thread or program.
#pragma once

#include <chrono>
#include <thread>

namespace kdstream::fixtures
{

// Returns whether the condition becomes true within a minute; only code that hangs takes that long.
// The condition is checked every 2 milliseconds.
template <class Condition>
bool Eventually(const Condition& condition)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!condition())
  {
    if (std::chrono::steady_clock::now() > end)
    {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}
