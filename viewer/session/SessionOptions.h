// SPDX-License-Identifier: BSD-3-Clause
// Options of a viewer's session: what it shows, and how much it holds.
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
  // The accepted screen-space error in points (pixels / pixel ratio). Above 0.
  double tolerance = 1;
  // A refined piece stays refined until its error is below the tolerance divided by this, at least
  // 1 (hysteresis). So small motions to and fro do not flicker.
  double deadBand = 1.25;
  // A model whose original has at most this number of triangles (points, of a cloud) is cheap to
  // draw. It is shown four times as fine: as the original, unless it is tiny on the screen.
  std::uint64_t smallModel = 0;
  // Most triangles (points, of a cloud) that are shown, and most bytes for their pieces. Where a
  // view needs more, the remaining error grows.
  std::uint64_t triangles = 2'000'000;
  std::size_t bytes = std::size_t{ 512 } << 20;
};

struct LevelPolicyOptions
{
  // A level is fine enough if its geometric error is at most this many points (pixels / pixel
  // ratio) on the screen. Above 0.
  double tolerance = 1;
  // A level stays as long as the tolerance, divided or multiplied by this, would still choose it.
  // So zooming back and forth across a threshold does not flicker. At least 1.
  double hysteresis = 1.25;
  // A limit for memory and frame rate: a level with more triangles is not chosen, except the
  // preview.
  std::uint64_t triangleBudget = 2'000'000;
};

struct LodOptions
{
  DetailMode detail = DetailMode::View;
  RefinementOptions refinement; // by the view
  LevelPolicyOptions policy;    // for views by one level
};

struct RegionLimits
{
  // The most pages and boxes of the tree that a pick may ask for.
  std::size_t treeBlobs = 1000;
  // The most partitions of a region: the nearest ones count.
  std::size_t partitions = 512;
  // About the most triangles of a region. It always has the picked partition.
  std::uint64_t triangles = std::numeric_limits<std::uint64_t>::max();
  // A region that has shrunk to fewer points than this on the screen is let go.
  double points = 32;
};

struct SessionOptions : LodOptions
{
  unsigned rings = 1; // around a picked cell, 1-3
  Turning turning = Turning::Upright;
  bool coasts = false; // the model keeps turning for a moment when it is released (Advance)
  RegionLimits region; // around a tap
  // Decoded pieces that are kept beyond what is shown, bytes.
  std::size_t cacheBytes = std::size_t{ 256 } << 20;
  // Bytes for the loaded pages of the model's tree.
  std::size_t treeBytes = standardTreeBytes;
  // Decoded pictures of textures that are kept, bytes.
  std::size_t pictureBytes = std::size_t{ 512 } << 20;
  // Prefetch, by the view: when everything that is wanted has arrived, pieces for a view at half
  // the distance are fetched, in the middle of the screen. At most about this number of bytes for
  // each view; 0: no prefetch.
  std::size_t prefetchBytes = 0;
  // Seconds of a steady clock, for parsing times only; without one these are 0.
  std::function<double()> clock;
  // The number of blobs in Statistics: the newest.
  std::size_t mostStatistics = 10'000;
  // All of the above that is held, at most.
  void TakeShares(const MemoryShares& shares);
  // After each input, `sink` is called with one line of JSON: the input, the state, the resulting
  // requests. The same inputs give the same lines. The code that writes them is linked only into
  // programs that call this, not into a page.
  void TraceTo(std::function<void(std::string_view)> sink);

private:
  friend class ViewerSession;
  std::function<void(std::string_view)> Sink;
  std::string (ViewerSession::*FormatTrace)(
    std::string_view input, std::string_view detail) const = nullptr; // with Sink
};

}
