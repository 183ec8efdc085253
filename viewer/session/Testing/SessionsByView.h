// SPDX-License-Identifier: BSD-3-Clause
// What tests of sessions that choose by the view share: a window, and a torus opened in it; taps on
// it, and what is shown of it.
#pragma once

#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

namespace kdstream::testing
{

constexpr int width = 800, height = 600;
constexpr double onRingX = 150, onRingY = 300; // pixels, where the torus is when it is opened

// P = 9, levels 11 … 16: 64,000 vertices.
inline const MemoryServer& Torus()
{
  static const MemoryServer server(MakeTorus(400, 160), 128, 2);
  return server;
}

inline void OpenFullScreen(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
}

// In a window a fifth as wide and high, where levels are fine enough.
inline void OpenSmall(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width / 5, height / 5, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  server.Serve(session);
}

inline void ExpectClosed(const ViewerSession& session)
{
  ASSERT_EQ(CountBoundaryEdges(session.Scene().surface->Whole().triangles), 0u);
}

// `clock`: that of the fingers, seconds, which goes on.
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
