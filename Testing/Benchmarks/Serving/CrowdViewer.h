// SPDX-License-Identifier: BSD-3-Clause
// One of thousands of viewers that view a model over a server's stream, all on one thread. It sends
// the requests of a real viewer (viewer/client/StreamConversation.h), but draws nothing.
#pragma once

#include "Testing/Benchmarks/Serving/CrowdWishes.h"

#include <boost/asio/io_context.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace kdstream::benchmarks
{

enum class Manner
{
  Eager,    // reads as fast as it can
  Slow,     // reads 16 KiB a second
  Deaf,     // stops reading after each tap, long enough for the server to drop it
  Vanishing // leaves without a word after each tap, and comes back
};

// Counts of what all viewers of a crowd have seen.
struct CrowdTally
{
  std::uint64_t bytes = 0, blobs = 0, acts = 0; // acts: zooms, taps and looks at the tree
  std::uint64_t refused = 0;                    // connections answered with 'try again'
  std::uint64_t dropped = 0;                    // ended by the server, except those of deaf viewers
  std::uint64_t deafDropped = 0, vanished = 0;
  std::uint64_t failures = 0; // damaged blobs, errors, and anything else that must not occur
  std::string firstFailure;
  std::vector<float> firstBlobs, lastBlobs; // of eager viewers' regions: seconds since the tap
};

// All calls must be made on the context's thread.
class CrowdViewer
{
public:
  // REQUIRES: context, model and tally outlive the viewer, and the context does not run after the
  // viewer's end.
  CrowdViewer(boost::asio::io_context& context, const CrowdModel& model, std::uint16_t port,
    Manner manner, std::uint32_t seed, CrowdTally& tally);
  ~CrowdViewer();
  CrowdViewer(CrowdViewer&&) noexcept;

  // Connects, opens the model, and gets its preview and the first page of the tree. Tries again if
  // it is refused.
  void Arrive();
  // Whether the viewer is connected and has everything that it has requested.
  bool IsSettled() const;
  // From now on the viewer zooms, taps and looks around, with this pause on average.
  void Roam(std::chrono::duration<double> pause);
  // Stops reading until GoOn, and requests the finest level and a number of partitions. Not for a
  // slow viewer, which would need minutes for these.
  void Hold(std::uint64_t partitions);
  void GoOn();
  // Closes the connection; the viewer does nothing more.
  void Leave();

private:
  class Mind;
  std::shared_ptr<Mind> Kept;
};

}
