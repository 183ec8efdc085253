// SPDX-License-Identifier: BSD-3-Clause
// The ends of distances: which partitions they wait for, and where they are when these have
// arrived.
#include "viewer/session/Testing/TorusModel.h"
#include "viewer/session/tools/MeasureTool.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

constexpr double slack = 0.02;
const Ray down{ { 1, 0, 5 }, { 0, 0, -1 } }, downAcross{ { -1, 0, 5 }, { 0, 0, -1 } };
const Ray beside{ { 9, 0, 5 }, { 0, 0, -1 } };

std::vector<PieceId> WantedOf(const MeasureTool& tool)
{
  std::vector<PieceId> pieces;
  tool.AddTo(pieces);
  return pieces;
}

TEST(TestMeasureTool, EndsComeToLieOnTheOriginal)
{
  TorusModel torus;
  torus.Show();
  MeasureTool tool(torus.model);
  EXPECT_FALSE(tool.MeasureAt(beside, slack));
  EXPECT_TRUE(tool.MeasureAt(down, slack));
  EXPECT_TRUE(tool.MeasureAt(downAcross, slack));
  ASSERT_EQ(tool.All().size(), 1u);
  EXPECT_NEAR(tool.All()[0].Distance(), 2, 0.1);
  EXPECT_GT(tool.All()[0].Error(), 0);
  EXPECT_FALSE(tool.All()[0].IsExact());

  tool.FollowTree(); // the tree is not known yet
  EXPECT_TRUE(WantedOf(tool).empty());
  EXPECT_FALSE(torus.model.open->tree.TakeMissing().empty());
  torus.TakeTree();
  for (int i = 0; i < 12 && tool.Waits(); ++i)
  {
    tool.FollowTree();
    ASSERT_FALSE(WantedOf(tool).empty());
    torus.Show(WantedOf(tool));
    tool.FollowSurface(slack);
  }
  EXPECT_FALSE(tool.Waits());
  EXPECT_TRUE(tool.All()[0].IsExact());
  EXPECT_TRUE(WantedOf(tool).empty());
}

TEST(TestMeasureTool, EndStaysOnTheLevelWhereItsPartitionFails)
{
  TorusModel torus;
  torus.Show();
  torus.TakeTree();
  MeasureTool tool(torus.model);
  ASSERT_TRUE(tool.MeasureAt(down, slack));
  tool.FollowTree();
  const auto wanted = WantedOf(tool);
  ASSERT_EQ(wanted.size(), 1u);
  EXPECT_TRUE(tool.All()[0].from.waits);
  torus.model.failed.Add(
    BlobOfPiece(wanted[0], torus.model.Depths()), wanted[0], "it is damaged", false);
  tool.FollowTree();
  EXPECT_FALSE(tool.Waits());
  EXPECT_FALSE(tool.All()[0].from.waits);
  EXPECT_GT(tool.All()[0].from.error, 0);
}

TEST(TestMeasureTool, HalfADistanceIsDroppedAndNamesGoOn)
{
  TorusModel torus;
  torus.Show();
  MeasureTool tool(torus.model);
  tool.DropHalf();
  tool.MeasureAt(down, slack);
  tool.DropHalf();
  EXPECT_TRUE(tool.All().empty());
  EXPECT_FALSE(tool.Waits());
  tool.Take({ { Vec3{ 1, 0, 0.3 }, Vec3{ -1, 0, 0.3 } } });
  EXPECT_EQ(tool.All().at(0).name, "2");
  tool.Name(0, "width");
  tool.Name(7, "none");
  EXPECT_EQ(tool.All()[0].name, "width");
  tool.Remove(1);
  EXPECT_EQ(tool.All().size(), 1u);
  tool.Remove(0);
  EXPECT_FALSE(tool.Waits());
  tool.Reset();
  tool.MeasureAt(down, slack);
  EXPECT_EQ(tool.All().at(0).name, "1");
}

}
