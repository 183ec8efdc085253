// SPDX-License-Identifier: BSD-3-Clause
// Shared by tests of sessions in view mode: a torus, taps on it, and counts of what is shown.
#pragma once

#include "viewer/session/Testing/SessionsOpened.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

namespace kdstream::testing
{

// P = 9, levels 11 … 16: 64,000 vertices.
inline const MemoryServer& Torus()
{
  static const MemoryServer server(MakeTorus(400, 160), 128, 2);
  return server;
}

// clock: the time of the touches in seconds; it advances.
inline void DoubleTap(ViewerSession& session, double x, double y, double& clock)
{
  clock += 1;
  for (int i = 0; i < 2; ++i)
  {
    session.HandleTouches({ clock += 0.1, { { 1, x, y } } });
    session.HandleTouches({ clock += 0.05, {} });
  }
}

inline std::size_t VerticesOfOriginal(const ViewerSession& session)
{
  const auto& sources = session.Scene().surface->Whole().sources;
  return static_cast<std::size_t>(std::count_if(sources.begin(), sources.end(),
    [](const auto& source) { return source.resolution.IsOriginal(); }));
}

}
