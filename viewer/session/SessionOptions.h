// SPDX-License-Identifier: BSD-3-Clause
// Options of a viewer's session: what it shows, and how much it keeps in memory.
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
  // A refined piece stays refined until its error is below the tolerance divided by this number
  // (hysteresis), so that small motions to and fro cause no flicker. At least 1.
  double deadBand = 1.25;
  // A model whose original has at most this number of triangles (points, for a cloud) is cheap to
  // draw. It is shown four times as fine: as the original, unless it is tiny on the screen.
  std::uint64_t smallModel = 0;
  // The most triangles (points, for a cloud) that are shown, and the most bytes for their pieces.
  // If a view needs more, the remaining error grows.
  std::uint64_t triangles = 2'000'000;
  std::size_t bytes = std::size_t{ 512 } << 20;
};

struct LevelPolicyOptions
{
  // A level is fine enough if its geometric error is at most this many points (pixels / pixel
  // ratio) on the screen. Above 0.
  double tolerance = 1;
  // A level stays as long as the tolerance, divided or multiplied by this, would still choose it.
  // So zooming back and forth across a threshold causes no flicker. At least 1.
  double hysteresis = 1.25;
  // A limit for memory and frame rate: a level with more triangles is not chosen, except the
  // preview.
  std::uint64_t triangleBudget = 2'000'000;
};

struct LodOptions
{
  DetailMode detail = DetailMode::View;
  RefinementOptions refinement; // in view mode
  LevelPolicyOptions policy;    // in level mode
};

struct RegionLimits
{
  // The most pages and boxes of the tree that a pick may request.
  std::size_t treeBlobs = 1000;
  // The most partitions of a region. If it has more, only the nearest ones are taken.
  std::size_t partitions = 512;
  // The approximate maximum number of triangles of a region. The picked partition is always in it.
  std::uint64_t triangles = std::numeric_limits<std::uint64_t>::max();
  // A region that has shrunk to fewer points than this on the screen is dropped.
  double points = 32;
};

struct SessionOptions : LodOptions
{
  unsigned rings = 1; // around a picked cell, 1-3
  Turning turning = Turning::Upright;
  bool coasts = false; // the model keeps turning for a moment when it is released (Advance)
  RegionLimits region; // around a tap
  // Bytes of decoded pieces, shown or not. Shown pieces are kept even if they exceed this.
  std::size_t cacheBytes = std::size_t{ 256 } << 20;
  // Bytes of the loaded pages of the model's tree.
  std::size_t treeBytes = standardTreeBytes;
  // Bytes of decoded pictures of textures.
  std::size_t pictureBytes = std::size_t{ 512 } << 20;
  // Prefetch, in view mode: when everything that is wanted has arrived, pieces for a view at half
  // the distance are fetched, in the middle of the screen. At most about this number of bytes for
  // each view; 0: no prefetch.
  std::size_t prefetchBytes = 0;
  // Returns the seconds of a steady clock. Used only for parsing times, which are 0 without a
  // clock.
  std::function<double()> clock;
  // How many blobs Statistics keeps: the newest ones.
  std::size_t mostStatistics = 10'000;
  // Sets those of the limits above that are in `shares`.
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
