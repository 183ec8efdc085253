// SPDX-License-Identifier: BSD-3-Clause
// One of thousands of viewers that view a model over a server's stream, all on one thread: with the
// requests of a real viewer (viewer/client/StreamConversation.h), but without drawing.
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
  Deaf,     // after each tap stops reading, long enough for the server to drop it
  Vanishing // after each tap goes without a word, and comes back
};

// What all viewers of a crowd have seen.
struct CrowdTally
{
  std::uint64_t bytes = 0, blobs = 0, acts = 0; // received whole; zooms, taps and looks at the tree
  std::uint64_t refused = 0;                    // connections answered with 'try again'
  std::uint64_t dropped = 0;                    // that the server ended, deaf ones' aside
  std::uint64_t deafDropped = 0, vanished = 0;
  std::uint64_t failures = 0; // damaged blobs, errors, whatever a viewer must not see
  std::string firstFailure;
  std::vector<float> firstBlobs, lastBlobs; // of eager viewers' regions: seconds since the tap
};

// All calls are on the context's thread.
class CrowdViewer
{
public:
  // REQUIRES: context, model and tally outlive the viewer, and the context runs no more after that.
  CrowdViewer(boost::asio::io_context& context, const CrowdModel& model, std::uint16_t port,
    Manner manner, std::uint32_t seed, CrowdTally& tally);
  ~CrowdViewer();
  CrowdViewer(CrowdViewer&&) noexcept;

  // Connects, opens the model and gets its preview and the first page of the tree. Tries again if
  // it is refused.
  void Arrive();
  // Whether it is connected and has all that it has asked for.
  bool IsSettled() const;
  // From now on zooms, taps and looks around, with this pause on average.
  void Roam(std::chrono::duration<double> pause);
  // Stops reading until it continues, and asks for the finest level and a number of partitions. Not
  // for a slow viewer, which would need minutes for these.
  void Hold(std::uint64_t partitions);
  void GoOn();
  // Closes its line, and comes to rest.
  void Leave();

private:
  class Mind;
  std::shared_ptr<Mind> Kept;
};

}
