// SPDX-License-Identifier: BSD-3-Clause
// Estimates bandwidth and round trip of the connection to the server, and from these how much
// should be in flight: step "request" of the pipeline picture.
#pragma once

#include <cstddef>

namespace kdstream
{

// The bytes in flight should fill the connection, but not exceed it, because they still have to
// arrive first when the view changes. The right amount is what a quarter of a second brings, or two
// round trips if these take longer.
class BandwidthMeter
{
public:
  // A blob of `bytes` bytes arrived `seconds` after its request, or after the blob before it,
  // whichever is later. single: nothing else was in flight when it was requested, so that the time
  // includes the round trip. Times of 0 or less, as in replays and from caches, are ignored.
  void Arrived(std::size_t bytes, double seconds, bool single);

  // The number of bytes that may be in flight: 12 KiB to 4 MiB; 64 KiB as long as nothing is known.
  // Until blobs have arrived directly after others, single blobs give a lower bound for the speed.
  std::size_t Window() const;

private:
  double RoundTrip(double rate) const;

  struct Sample
  {
    double bytes = 0, seconds = 0;
  };
  Sample Following; // blobs that arrived right after another one; newer ones count more
  Sample Single;    // the fastest blob that was requested by itself
};

}
