// SPDX-License-Identifier: BSD-3-Clause
// What a whole look took: bytes, seconds, triangles, memory. The contract is
// doc/cli.md#report-of-a-viewer.
#pragma once

#include "viewer/session/SessionTypes.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace kdstream
{

// The resident memory of this process now, bytes; 0 where it cannot be told.
std::uint64_t ResidentMemory();

class ViewReport
{
public:
  // Its seconds begin now.
  ViewReport();

  // A frame has been drawn.
  void AddFrame(const ViewerStatus& status);
  // One JSON object. link: to what is seen at the end.
  std::string Json(const SessionTraffic& traffic, const std::string& link) const;

private:
  double Now() const;

  std::chrono::steady_clock::time_point Begin;
  double First = -1;   // s; of the first frame with anything on it, -1 before
  double Settled = -1; // s; of the last frame that showed something else
  std::uint64_t Vertices = 0, Triangles = 0, PeakTriangles = 0;
};

}
