// SPDX-License-Identifier: BSD-3-Clause
// Waiting for what another thread or program does.
#pragma once

#include <chrono>
#include <thread>

namespace kdstream::fixtures
{

// Whether the condition becomes true within a minute, which only what hangs takes. It is looked at every 2 milliseconds.
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
