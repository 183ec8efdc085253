// SPDX-License-Identifier: BSD-3-Clause
// A report of a whole view: bytes, seconds, triangles, memory. Its format is promised in
// doc/cli.md#report-of-a-viewer.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace kdstream
{

// The resident memory of this process now, in bytes; 0 if unknown.
std::uint64_t ResidentMemory();

class ViewReport
{
public:
  // Time is counted from here.
  ViewReport();

  // Call this after a frame of this scene has been drawn.
  void AddFrame(const ViewerStatus& status, const ViewerScene& scene);
  // Returns one JSON object. link: to the view at the end.
  std::string Json(const SessionTraffic& traffic, const std::string& link) const;

private:
  double Now() const;

  std::chrono::steady_clock::time_point Begin;
  double First = -1;   // s; of the first frame that shows anything; -1: none yet
  double Settled = -1; // s; of the last frame in which the surface or its textures changed
  // Surface: the version of the surface that was drawn last.
  std::uint64_t Surface = 0, PeakTriangles = 0;
  std::shared_ptr<const TileList> Tiles;
};

}
