// SPDX-License-Identifier: BSD-3-Clause
// The times in a report: the first picture, and the last that showed something new.
#include "viewer/desktop/ViewReport.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <thread>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

nlohmann::json Reported(const ViewReport& report, const ViewerSession& session)
{
  return nlohmann::json::parse(report.Json(session.GetTraffic(), "model=torus"));
}

// Draws frames as a viewer does, with some time between them.
class Frames
{
public:
  explicit Frames(ViewerSession& session)
    : Session(session)
  {
  }

  void Draw()
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    this->Session.BeginFrame();
    this->Report.AddFrame(this->Session.GetStatus(), this->Session.Scene());
    this->Session.EndFrame(0);
  }
  void DrawAll(MemoryServer& server)
  {
    do
    {
      this->Draw();
    } while (server.Answer(this->Session));
  }
  double Seconds(const char* key) const { return Reported(this->Report, this->Session).at(key); }
  nlohmann::json All() const { return Reported(this->Report, this->Session); }

private:
  ViewerSession& Session;
  ViewReport Report;
};

TEST(TestViewReport, WithoutAPictureNothingIsReported)
{
  ViewerSession session;
  Frames frames(session);
  frames.Draw();
  EXPECT_TRUE(frames.All().at("seconds_to_first").is_null());
  EXPECT_TRUE(frames.All().at("seconds_to_settled").is_null());
  EXPECT_EQ(frames.All().at("peak_triangles"), 0);
}

TEST(TestViewReport, WhatIsSettledStaysSo)
{
  MemoryServer server(MakeTorus(200, 80), 128, 2);
  ViewerSession session;
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  Frames frames(session);
  frames.DrawAll(server);
  const double settled = frames.Seconds("seconds_to_settled");
  EXPECT_LT(frames.Seconds("seconds_to_first"), settled);
  frames.Draw();
  EXPECT_EQ(frames.Seconds("seconds_to_settled"), settled);
  session.Zoom(4, onRingX, onRingY);
  frames.DrawAll(server);
  EXPECT_GT(frames.Seconds("seconds_to_settled"), settled);
  EXPECT_EQ(frames.All().at("link"), "model=torus");
}

// The shape stays the same, but textures still arrive.
TEST(TestViewReport, APictureIsNotSettledBeforeItsTextures)
{
  MemoryServer server(MakeTorus(200, 80), 128, 2);
  server.AddTiles(128);
  ViewerSession session;
  OpenSmall(session, server);
  session.Resize({ width, height, 1 });
  session.Zoom(8, onRingX, onRingY);
  Frames frames(session);
  std::uint64_t shape = 0, pictures = 0; // frames that brought a new one
  double settled = 0;
  do
  {
    const std::uint64_t before = session.Scene().surfaceVersion;
    frames.Draw();
    if (before != session.Scene().surfaceVersion)
    {
      ++shape;
      settled = frames.Seconds("seconds_to_settled");
      pictures = 0;
    }
    else if (session.Scene().tiles->size() > pictures)
    {
      EXPECT_GT(frames.Seconds("seconds_to_settled"), settled) << "a texture came";
      settled = frames.Seconds("seconds_to_settled");
      pictures = session.Scene().tiles->size();
    }
  } while (server.Answer(session));
  EXPECT_GT(shape, 0u);
  EXPECT_GT(pictures, 2u) << "after the last of the shape";
}

}
