// SPDX-License-Identifier: BSD-3-Clause
// What tests of sessions share: a window, and the torus of a server opened in it.
#pragma once

#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

namespace kdstream::testing
{

constexpr int width = 800, height = 600;
constexpr double onRingX = 150, onRingY = 300; // pixels, where the torus is when it is opened

inline void OpenFullScreen(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
}

// Until the view needs nothing more: what is prefetched is in flight.
inline void OpenUntilIdle(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  for (server.Take(session); !session.IsIdle(); server.Take(session))
  {
    ASSERT_TRUE(server.Answer(session));
    session.BeginFrame();
  }
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

}
