// SPDX-License-Identifier: BSD-3-Clause
// The history of a session's blobs: which blobs get the time of a frame, and that the history does
// not grow forever.
#include "viewer/session/requests/BlobHistory.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

PieceId Id(NodeId node)
{
  return { Resolution::Original(), node };
}

BlobStatistics Entry(NodeId node, std::uint64_t triangles)
{
  BlobStatistics entry;
  entry.id = "partitions/" + std::to_string(node);
  entry.triangles = triangles;
  return entry;
}

TEST(TestBlobHistory, BlobsShareTheTimeOfTheFrameThatShowsThemFirst)
{
  BlobHistory history(10);
  history.Add(Id(1), Entry(1, 2));
  history.Add(Id(2), Entry(2, 5));
  history.Add(Id(3), Entry(3, 100)); // not shown
  history.BeginFrame({ Id(1), Id(2), Id(7) });
  history.EndFrame(9);
  EXPECT_EQ(history.Entries()[0].renderingSeconds, 3);
  EXPECT_EQ(history.Entries()[1].renderingSeconds, 6);
  EXPECT_EQ(history.Entries()[2].renderingSeconds, 0);
  history.BeginFrame({ Id(1), Id(2) }); // not the first frame that shows them
  history.EndFrame(50);
  EXPECT_EQ(history.Entries()[0].renderingSeconds, 3);
  history.CloseModel();
  history.BeginFrame({ Id(3) }); // a piece of another model
  history.EndFrame(50);
  EXPECT_EQ(history.Entries()[2].renderingSeconds, 0);
}

TEST(TestBlobHistory, MayKeepNone)
{
  BlobHistory history(0);
  history.Add(Id(1), Entry(1, 2));
  history.BeginFrame({ Id(1) });
  history.EndFrame(9);
  EXPECT_TRUE(history.Entries().empty());
}

TEST(TestBlobHistory, KeepsTheNewest)
{
  BlobHistory history(3);
  for (NodeId node = 1; node <= 5; ++node)
  {
    history.Add(Id(node), Entry(node, 0));
  }
  ASSERT_EQ(history.Entries().size(), 3u);
  EXPECT_EQ(history.Entries().front().id, "partitions/3");
  EXPECT_EQ(history.Entries().back().id, "partitions/5");
  history.BeginFrame({ Id(1), Id(3), Id(5) }); // the first entry has been forgotten
  history.EndFrame(8);
  EXPECT_EQ(history.Entries()[0].renderingSeconds, 4);
  EXPECT_EQ(history.Entries()[1].renderingSeconds, 0);
  EXPECT_EQ(history.Entries()[2].renderingSeconds, 4);
  // An entry that is forgotten while a frame is drawn gets no time.
  history.Add(Id(6), Entry(6, 0));
  history.BeginFrame({ Id(4), Id(6) });
  history.Add(Id(7), Entry(7, 0));
  history.EndFrame(2);
  EXPECT_EQ(history.Entries()[1].id, "partitions/6");
  EXPECT_EQ(history.Entries()[1].renderingSeconds, 2);
}

TEST(TestBlobHistory, WhatIsNeverShownIsWasted)
{
  BlobHistory history(10);
  history.Count(100, false); // a page of the tree
  history.Count(20, true);   // nobody has waited for it
  history.Count(300, false);
  BlobStatistics entry = Entry(1, 2);
  entry.bytes = 300;
  history.Add(Id(1), entry);
  EXPECT_EQ(history.Traffic().blobs, 3u);
  EXPECT_EQ(history.Traffic().bytes, 420u);
  EXPECT_EQ(history.Traffic().wasted, 320u);
  history.AddLate(Id(2), 20);
  history.BeginFrame({ Id(1), Id(2) });
  EXPECT_EQ(history.Traffic().wasted, 0u);
  history.BeginFrame({ Id(1), Id(2) });
  EXPECT_EQ(history.Traffic().wasted, 0u);
}

}
