// SPDX-License-Identifier: BSD-3-Clause
// How fast the line to the server is, and so how much to prefetch: step "request" of the
// pipeline picture.
#pragma once

#include <cstddef>

namespace kdstream
{

// What has been asked for and has not come should fill the line, and no more: what is in flight
// when one looks elsewhere must be waited for. A quarter of a second of the line does, or two round
// trips where these take longer.
class LineMeter
{
public:
  // A blob of so many bytes came so many seconds after it was asked for or, if that is later, after
  // the blob before it. alone: nothing else was in flight when it was asked for, so that it tells
  // of the round trip too. Times of 0 or less, as of replays and of caches, tell nothing.
  void Arrived(std::size_t bytes, double seconds, bool alone);

  // So many bytes may be in flight: 12 KiB to 4 MiB; where nothing is known, 64 KiB. While nothing
  // has come behind something else, what came by itself tells how slow the line may be.
  std::size_t Window() const;

private:
  double RoundTrip(double rate) const;

  struct Sample
  {
    double bytes = 0, seconds = 0;
  };
  Sample Behind; // what came close behind something else, newest most
  Sample Alone;  // what came by itself, soonest
};

}
