// SPDX-License-Identifier: BSD-3-Clause
// What fingers do with the chosen tool, and which gestures are left for the camera.
#include "viewer/session/Testing/TorusModel.h"
#include "viewer/session/tools/Tools.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::testing;
using Kind = Gesture::Kind;

namespace
{

struct InHand : TorusModel
{
  Tools tools{ this->model };
  Camera camera;

  InHand()
  {
    this->camera.SetViewport({ width, height, 1 });
    this->camera.FitTo(this->server.Description().box);
  }
  bool Take(Kind kind, double x, double y, double dx = 0, double dy = 0)
  {
    return this->tools.Take({ kind, x, y, dx, dy }, this->camera);
  }
};

TEST(TestTools, NothingInHandLeavesAllToTheCamera)
{
  InHand hand;
  hand.Show();
  for (const Kind kind : { Kind::Rotate, Kind::Pinch, Kind::Tap, Kind::DoubleTap })
  {
    EXPECT_FALSE(hand.Take(kind, onRingX, onRingY, 10, 10));
  }
}

TEST(TestTools, OneFingerMovesTheSectionTwoTurnIt)
{
  InHand hand;
  hand.tools.TakeInHand(Tool::Section);
  EXPECT_FALSE(hand.Take(Kind::Rotate, 400, 300, 0, 50)); // there is no section
  ASSERT_TRUE(hand.model.section.SetAlong("y", { 0, 0, 1 }));
  const double depth = hand.model.section.Depth();
  EXPECT_TRUE(hand.Take(Kind::Rotate, 400, 300, 0, 50));
  EXPECT_NE(hand.model.section.Depth(), depth);
  const Vec3 normal = hand.model.section.Plane()->normal;
  EXPECT_TRUE(hand.Take(Kind::Pinch, 400, 300, 0, 200));
  EXPECT_LT(Dot(hand.model.section.Plane()->normal, normal), 0.9);
  EXPECT_FALSE(hand.Take(Kind::PinchBegin, 400, 300));
}

TEST(TestTools, LightComesFromWhereTheFingerIs)
{
  InHand hand;
  hand.tools.TakeInHand(Tool::Light);
  EXPECT_TRUE(hand.Take(Kind::Rotate, 400, 300));
  EXPECT_EQ(hand.tools.Light()->lightSource.x, 0);
  EXPECT_FALSE(hand.tools.Light()->second);
  EXPECT_FALSE(hand.Take(Kind::Pinch, 400, 300));
  hand.tools.TakeInHand(Tool::SecondLight);
  EXPECT_TRUE(hand.Take(Kind::Tap, 535, 300));
  EXPECT_EQ(hand.tools.Light()->lightSource.x, 0);
  EXPECT_DOUBLE_EQ(hand.tools.Light()->second->x, 0.5);
  hand.tools.Reset();
  EXPECT_FALSE(hand.tools.Light());
  EXPECT_EQ(hand.tools.InHand(), Tool::SecondLight);
}

TEST(TestTools, TapsMeasureAndBesideTheModelADoubleTapIsLeft)
{
  InHand hand;
  hand.Show();
  hand.tools.TakeInHand(Tool::Measure);
  EXPECT_TRUE(hand.Take(Kind::Tap, onRingX, onRingY));
  EXPECT_TRUE(hand.Take(Kind::DoubleTap, onRingX + 5, onRingY));
  EXPECT_EQ(hand.tools.Measuring().All().size(), 1u);
  EXPECT_FALSE(hand.Take(Kind::DoubleTap, 1, 1));
  hand.Take(Kind::Tap, onRingX, onRingY);
  hand.tools.TakeInHand(Tool::None); // drops the unfinished measurement
  EXPECT_EQ(hand.tools.Measuring().All().size(), 1u);
}

TEST(TestTools, ALinkNamesThemWhereverTheModelIs)
{
  InHand hand;
  hand.model.section.Set(SectionPlane{ { 0, 0, 1 }, 0.1 });
  hand.tools.SetLight(RakingLight{ { 0.5, 0.25, 1 } });
  hand.tools.Measuring().Take({ { Vec3{ 1, 0, 0.3 }, Vec3{ -1, 0, 0.3 } } });
  ViewLink link;
  hand.tools.PutInto(link, hand.camera);

  InHand other;
  other.model.section.SetAlong("x", { 0, 0, 1 });
  other.tools.TakeFrom(link, other.camera);
  EXPECT_EQ(other.tools.Light(), hand.tools.Light());
  EXPECT_NEAR(other.model.section.Plane()->offset, 0.1, 1e-9);
  EXPECT_NEAR(other.tools.Measuring().All().at(0).Distance(), 2, 1e-9);
  other.tools.TakeFrom({}, other.camera);
  EXPECT_FALSE(other.model.section.Plane());
  EXPECT_TRUE(other.tools.Measuring().All().empty());
  EXPECT_FALSE(other.tools.Light());
}

TEST(TestTools, OutlineIsEmptyWithoutASection)
{
  InHand hand;
  EXPECT_EQ(SectionOutline(hand.model), "");
  hand.Show();
  hand.model.section.Set(SectionPlane{ { 0, 0, 1 }, 0 });
  hand.model.FollowSection();
  std::string svg = SectionOutline(hand.model);
  EXPECT_NE(svg.find("<path"), std::string::npos);
  EXPECT_NE(svg.find("<desc>Of a coarser level: about "), std::string::npos) << "of the preview";
  std::vector<PieceId> original;
  const ModelDescription& model = hand.server.Description();
  for (std::uint32_t i = 0; i < model.partitions; ++i)
  {
    original.push_back({ Resolution::Original(), NodeOfPartition(i, model.depths) });
  }
  hand.Show(original);
  hand.model.FollowSection();
  svg = SectionOutline(hand.model);
  EXPECT_NE(svg.find("<desc>Within "), std::string::npos) << svg.substr(0, 300);
}

}
