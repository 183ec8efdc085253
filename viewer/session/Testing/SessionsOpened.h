// SPDX-License-Identifier: BSD-3-Clause
// Shared by tests of sessions: a window, and opening the torus of a server in it.
#pragma once

#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

namespace kdstream::testing
{

constexpr int width = 800, height = 600;
constexpr double onRingX = 150, onRingY = 300; // a pixel that shows the torus after it is opened

inline void OpenFullScreen(ViewerSession& session, MemoryServer& server)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
}

// Opens the torus, and answers until the view needs nothing more. Prefetched blobs are still in
// flight.
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

// Opens the torus in a window a fifth as wide and high, for which levels are fine enough.
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
