// SPDX-License-Identifier: BSD-3-Clause
// How fast the line to the server is: see LineMeter.h.
#include "viewer/session/line/LineMeter.h"

#include <algorithm>

namespace kdstream
{
namespace
{
constexpr double leastWindow = 12 * 1024, firstWindow = 64 * 1024, mostWindow = 4096.0 * 1024;
constexpr double leastAhead = 0.25; // s
// Earlier blobs count less with each new one: the last dozen decide.
constexpr double remembered = 0.92;
}

void LineMeter::Arrived(std::size_t bytes, double seconds, bool alone)
{
  if (!(seconds > 0))
  {
    return;
  }
  if (!alone)
  {
    this->Behind.bytes = this->Behind.bytes * remembered + static_cast<double>(bytes);
    this->Behind.seconds = this->Behind.seconds * remembered + seconds;
  }
  else if (!(this->Alone.seconds > 0) || seconds < this->Alone.seconds)
  {
    this->Alone = { static_cast<double>(bytes), seconds };
  }
}

// What came by itself took a round trip, and its own time on the line.
double LineMeter::RoundTrip(double rate) const
{
  return std::max(0.0, this->Alone.seconds - this->Alone.bytes / rate);
}

std::size_t LineMeter::Window() const
{
  const Sample& sample = this->Behind.seconds > 0 ? this->Behind : this->Alone;
  if (!(sample.seconds > 0))
  {
    return static_cast<std::size_t>(firstWindow);
  }
  const double rate = sample.bytes / sample.seconds;
  const double window = rate * std::max(leastAhead, 2 * this->RoundTrip(rate));
  return static_cast<std::size_t>(
    window >= leastWindow ? std::min(window, mostWindow) : leastWindow); // nor NaN
}

}
