// SPDX-License-Identifier: BSD-3-Clause
// Bandwidth and round trip of the connection: see BandwidthMeter.h.
#include "viewer/session/requests/BandwidthMeter.h"

#include <algorithm>

namespace kdstream
{
namespace
{
constexpr double leastWindow = 12 * 1024, firstWindow = 64 * 1024, mostWindow = 4096.0 * 1024;
constexpr double leastAhead = 0.25; // s
// Each new blob multiplies the weight of earlier ones by this, so about the last dozen decide.
constexpr double remembered = 0.92;
}

void BandwidthMeter::Arrived(std::size_t bytes, double seconds, bool single)
{
  if (!(seconds > 0))
  {
    return;
  }
  if (!single)
  {
    this->Following.bytes = this->Following.bytes * remembered + static_cast<double>(bytes);
    this->Following.seconds = this->Following.seconds * remembered + seconds;
  }
  else if (!(this->Single.seconds > 0) || seconds < this->Single.seconds)
  {
    this->Single = { static_cast<double>(bytes), seconds };
  }
}

// The round trip: the time of a blob that was requested by itself, without the time for its bytes.
double BandwidthMeter::RoundTrip(double rate) const
{
  return std::max(0.0, this->Single.seconds - this->Single.bytes / rate);
}

std::size_t BandwidthMeter::Window() const
{
  const Sample& sample = this->Following.seconds > 0 ? this->Following : this->Single;
  if (!(sample.seconds > 0))
  {
    return static_cast<std::size_t>(firstWindow);
  }
  const double rate = sample.bytes / sample.seconds;
  const double window = rate * std::max(leastAhead, 2 * this->RoundTrip(rate));
  return static_cast<std::size_t>(
    window >= leastWindow ? std::min(window, mostWindow) : leastWindow); // also instead of NaN
}

}
