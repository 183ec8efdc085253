// SPDX-License-Identifier: BSD-3-Clause
// Shared by tests of sessions that show one level for the whole model: a torus in memory, and
// fingers.
#pragma once

#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/Testing/SessionsOpened.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace kdstream::testing
{

// P = 7, S = 11, L = 13: the preview is level S. For levels coarser than S use SmallCells, with P =
// 8, S = 12, L = 13.
inline const MemoryServer& SmallTorus()
{
  static const MemoryServer server(MakeTorus(200, 80), 128, 2);
  return server;
}
inline const MemoryServer& SmallCells()
{
  static const MemoryServer server(MakeTorus(200, 80), 64, 2);
  return server;
}

// Options for one level for the whole model. TestViewDetail tests view mode.
inline SessionOptions ByLevel()
{
  SessionOptions options;
  options.detail = DetailMode::Level;
  return options;
}

inline SessionOptions WithTrace(std::vector<std::string>& trace)
{
  SessionOptions options = ByLevel();
  options.TraceTo([&trace](std::string_view line) { trace.emplace_back(line); });
  return options;
}

inline void Open(ViewerSession& session)
{
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
}

// A pixel that shows the ring of the torus.
inline std::pair<double, double> OnModel(const ViewerSession& session)
{
  const ViewerScene scene = session.Scene();
  const Vec3 v = Vec3{ 1, 0, 0.3 } - scene.eye;
  const Vec3 right = scene.orientation.Rotate({ 1, 0, 0 }),
             up = scene.orientation.Rotate({ 0, 1, 0 });
  const double scale =
    height / (2 * Camera::tangentOfHalfAngle * Dot(v, scene.orientation.Rotate({ 0, 0, -1 })));
  return { width * 0.5 + Dot(v, right) * scale, height * 0.5 - Dot(v, up) * scale };
}

// Fingers on the screen, with a clock of their own.
struct Fingers
{
  double now = 0;

  void Tap(ViewerSession& session, double x, double y)
  {
    session.HandleTouches({ this->now += 0.1, { { 1, x, y } } });
    session.HandleTouches({ this->now += 0.05, {} });
  }
  void DoubleTap(ViewerSession& session, double x, double y)
  {
    this->now += 1;
    this->Tap(session, x, y);
    this->Tap(session, x, y);
  }
  void Pinch(ViewerSession& session, double x, double y, double factor)
  {
    const double from = factor > 1 ? 30 : 30 / factor;
    for (int i = 0; i <= 10; ++i)
    {
      const double gap = from * (1 + (factor - 1) * i / 10);
      session.HandleTouches({ this->now += 0.02, { { 1, x - gap, y }, { 2, x + gap, y } } });
    }
    session.HandleTouches({ this->now += 0.02, {} });
  }
};

// Answers requests until a tapped region is known: a double tap needs pages and boxes of the tree
// before partitions are requested.
inline void TakeTree(ViewerSession& session, MemoryServer& server)
{
  while (!session.GetStatus().region)
  {
    ASSERT_TRUE(server.Answer(session));
  }
}

}
