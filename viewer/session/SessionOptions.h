// SPDX-License-Identifier: BSD-3-Clause
// What may be chosen of a viewer's session before it begins: what it shows, and how much it holds.
#pragma once

#include "viewer/session/MemoryBudget.h"
#include "viewer/session/SessionTypes.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>

namespace kdstream
{

class ViewerSession;

struct RefinementOptions
{
  // Points of the screen (pixels / pixel ratio): an error of so many is not seen. Above 0.
  double tolerance = 1;
  // What is refined stays so until its error is below the tolerance divided by this, at least 1: so
  // moving to and fro a little does not flicker.
  double deadBand = 1.25;
  // A model whose original has at most so many triangles (points, of a cloud) costs little, and is
  // shown four times as fine: as it is, but where it is tiny on the screen.
  std::uint64_t smallModel = 0;
  // What may be shown (points, of a cloud), and what the pieces for it may take of memory, bytes.
  // Where more would be needed, the error that is left grows.
  std::uint64_t triangles = 2'000'000;
  std::size_t bytes = std::size_t{ 512 } << 20;
};

struct LevelPolicyOptions
{
  // A level is fine enough where its deviation is at most this many points (pixels / pixel ratio)
  // on the screen. Above 0.
  double tolerance = 1;
  // A level stays as long as the tolerance, divided or multiplied by this, would still choose it.
  // So zooming to and fro around a border does not flicker. At least 1.
  double hysteresis = 1.25;
  // What memory and frame rate allow: a level with more triangles is not chosen, but for the
  // preview.
  std::uint64_t triangleBudget = 2'000'000;
};

struct LodOptions
{
  DetailMode detail = DetailMode::View;
  RefinementOptions refinement; // by the view
  LevelPolicyOptions policy;    // by one level for all
};

struct RegionLimits
{
  // A pick may ask for so many pages and boxes of the tree.
  std::size_t treeBlobs = 1000;
  // A region takes at most so many partitions, nearest first,
  std::size_t partitions = 512;
  // and about as many as have so many triangles, but at least the one that was picked.
  std::uint64_t triangles = std::numeric_limits<std::uint64_t>::max();
  // A region that has shrunk to fewer points than this on the screen is let go.
  double points = 32;
};

struct SessionOptions : LodOptions
{
  unsigned rings = 1; // around a picked cell, 1-3
  Turning turning = Turning::Upright;
  bool coasts = false; // the model turns on for a moment when it is let go (Advance)
  RegionLimits region; // around a tap
  // Decoded pieces that are kept beyond what is shown, bytes.
  std::size_t cacheBytes = std::size_t{ 256 } << 20;
  // What is kept of the model's tree, bytes.
  std::size_t treeBytes = standardTreeBytes;
  // Decoded pictures of textures that are kept, bytes.
  std::size_t pictureBytes = std::size_t{ 512 } << 20;
  // By the view, when all that is wanted is there: what one would want next, nearer by half in the
  // middle of the screen, is fetched until about so many bytes were asked for, once for each view.
  // 0: nothing is fetched ahead.
  std::size_t aheadBytes = 0;
  // Seconds of a steady clock, for parsing times only; without one these are 0.
  std::function<double()> clock;
  // Blobs of which Statistics tells: the newest.
  std::size_t mostStatistics = 10'000;
  // All of the above that is held, at most.
  void TakeShares(const MemoryShares& shares);
  // From then on, `sink` is called with one line of JSON after every input: the input, the state,
  // the requests that it led to. The same inputs give the same lines. What writes them is linked
  // only where this is called: a page does without.
  void TraceTo(std::function<void(std::string_view)> sink);

private:
  friend class ViewerSession;
  std::function<void(std::string_view)> Sink;
  std::string (ViewerSession::*FormatTrace)(
    std::string_view input, std::string_view detail) const = nullptr; // with Sink
};

}
