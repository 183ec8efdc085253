// SPDX-License-Identifier: BSD-3-Clause
// How fast the line to the server is: see LineMeter.h.
#include "viewer/session/LineMeter.h"

#include <algorithm>

namespace kdstream
{
namespace
{
constexpr double leastWindow = 12 * 1024, firstWindow = 64 * 1024, mostWindow = 4096.0 * 1024;
constexpr double leastAhead = 0.25; // s
// What came before counts so much less with each blob: the last dozen tell.
constexpr double memory = 0.92;
}

void LineMeter::Arrived(std::size_t bytes, double seconds, bool alone)
{
  if (!(seconds > 0))
  {
    return;
  }
  if (alone)
  {
    this->RoundTrip = this->RoundTrip > 0 ? std::min(this->RoundTrip, seconds) : seconds;
    return;
  }
  this->Bytes = this->Bytes * memory + static_cast<double>(bytes);
  this->Seconds = this->Seconds * memory + seconds;
}

std::size_t LineMeter::Window() const
{
  if (!(this->Seconds > 0))
  {
    return static_cast<std::size_t>(firstWindow);
  }
  const double ahead = std::max(leastAhead, 2 * this->RoundTrip);
  const double window = this->Bytes / this->Seconds * ahead;
  return static_cast<std::size_t>(std::clamp(window, leastWindow, mostWindow));
}

}
