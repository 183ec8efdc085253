// SPDX-License-Identifier: BSD-3-Clause
// LOD selection: which pieces of a model are wanted, in which order, and when a new choice is
// needed.
#include "viewer/session/Testing/TorusModel.h"
#include "viewer/session/model/LodSelection.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

struct Selected : TorusModel
{
  LodSelection lod;
  Camera camera;
  LodSelection::View view{ this->camera, true };

  explicit Selected(DetailMode detail, const MemoryServer& torus = SmallTorus())
    : TorusModel(torus)
    , lod(this->model, { detail, {}, {} })
  {
    this->camera.SetViewport({ width, height, 1 });
    this->camera.FitTo(this->server.Description().box);
    this->lod.Open();
  }
  void Take(const BlobId& blob)
  {
    if (IsOfTree(blob))
    {
      ASSERT_TRUE(this->TakeOfTree(blob));
      return;
    }
    const PieceId id = PieceOfBlob(blob, this->model.Depths());
    auto piece = DecodePiece(this->server.Blob(blob), id, this->model.open->codec);
    ASSERT_TRUE(piece);
    this->lod.Add(*piece);
    this->model.Add(std::move(*piece));
  }
  // Follows the view; returns what is missing.
  std::vector<BlobId> Follow()
  {
    this->lod.Follow(this->view);
    this->lod.SetDue();
    while (this->lod.IsDue())
    {
      if (const auto missing = this->lod.Choose(this->view))
      {
        EXPECT_TRUE(this->model.surface.Draw(this->model.pieces));
        return *missing;
      }
      this->lod.Follow(this->view); // the preview has just appeared
    }
    return {};
  }
  // Adds everything that is wanted, until nothing is missing; returns it.
  std::vector<BlobId> FollowToTheEnd()
  {
    std::vector<BlobId> all;
    for (auto missing = this->Follow(); !missing.empty(); missing = this->Follow())
    {
      this->Take(missing.front());
      all.push_back(missing.front());
    }
    return all;
  }
};

TEST(TestLodSelection, PreviewComesFirstThenWhatTheViewNeeds)
{
  Selected torus(DetailMode::View, Torus());
  EXPECT_EQ(torus.Follow(), std::vector{ torus.model.PreviewBlob() });
  const auto all = torus.FollowToTheEnd();
  EXPECT_EQ(all.front(), torus.model.PreviewBlob());
  EXPECT_GT(all.size(), 5u);
  EXPECT_FALSE(torus.lod.WaitsForTree());
  ViewerStatus status;
  torus.lod.PutInto(status);
  EXPECT_EQ(status.shownLevel, status.targetLevel);
  EXPECT_GT(*status.shownLevel, torus.model.Preview().resolution.Depth());

  // If nothing has changed, there is nothing to choose.
  torus.lod.Follow(torus.view);
  EXPECT_FALSE(torus.lod.IsDue());
  torus.view.region = { NodeOfPartition(1, torus.model.Depths()), 1 };
  torus.lod.Follow(torus.view);
  EXPECT_TRUE(torus.lod.IsDue());
}

TEST(TestLodSelection, NothingBeyondThePreviewWhileBrowsing)
{
  Selected torus(DetailMode::View, Torus());
  torus.view.isFullScreen = false;
  EXPECT_EQ(torus.FollowToTheEnd(), std::vector{ torus.model.PreviewBlob() });
  torus.view.isFullScreen = torus.view.previewsOnly = true;
  EXPECT_TRUE(torus.FollowToTheEnd().empty());
}

TEST(TestLodSelection, TappedPartitionsComeBeforeAllElseButTheTree)
{
  Selected torus(DetailMode::View, Torus());
  torus.Take(torus.model.PreviewBlob());
  torus.Follow();
  torus.TakeTree();
  torus.view.tapped = { torus.model.Partition(5), torus.model.Partition(2) };
  const auto order = torus.Follow();
  const auto at = [&](const BlobId& blob)
  { return std::find(order.begin(), order.end(), blob) - order.begin(); };
  EXPECT_LT(at(BlobId::Partition(5)), at(BlobId::Partition(2)));
  // Before the first partition only pieces above it are requested; between the first and the
  // second, only pieces above the second.
  const auto isIntermediate = [&](const BlobId& blob, std::uint32_t partition)
  {
    const TreeDepths& depths = torus.model.Depths();
    const NodeId node = PieceOfBlob(blob, depths).node;
    return NodeOfPartition(partition, depths) >> (depths.partition - DepthOfNode(node)) == node;
  };
  for (auto i = 0; i < at(BlobId::Partition(2)); ++i)
  {
    EXPECT_TRUE(isIntermediate(order[static_cast<std::size_t>(i)], 5) ||
                isIntermediate(order[static_cast<std::size_t>(i)], 2));
  }
}

TEST(TestLodSelection, OneLevelIsTheNextCoarserOneWhereAPieceFailed)
{
  Selected torus(DetailMode::Level);
  torus.lod.FollowZoom(1e6);
  torus.FollowToTheEnd();
  ViewerStatus status;
  torus.lod.PutInto(status);
  const unsigned finest = torus.model.Depths().finest;
  EXPECT_EQ(status.shownLevel, finest);

  Selected other(DetailMode::Level);
  other.lod.FollowZoom(1e6);
  const BlobId refused = BlobId::LevelPiece(static_cast<std::uint8_t>(finest), 4);
  other.model.failed.Add(
    refused, PieceOfBlob(refused, other.model.Depths()), "it is damaged", false);
  const auto all = other.FollowToTheEnd();
  EXPECT_EQ(std::count(all.begin(), all.end(), refused), 0);
  other.lod.PutInto(status);
  EXPECT_EQ(status.shownLevel, finest - 1);
  EXPECT_EQ(status.targetLevel, finest);
  other.lod.AimAtPreview();
  other.FollowToTheEnd();
  other.lod.PutInto(status);
  EXPECT_EQ(status.shownLevel, other.model.Preview().resolution.Depth());
}

TEST(TestLodSelection, AllOfTheOriginal)
{
  Selected torus(DetailMode::Full);
  const auto all = torus.FollowToTheEnd();
  EXPECT_EQ(static_cast<std::uint64_t>(std::count_if(all.begin(), all.end(),
              [](const BlobId& blob) { return blob.kind == BlobKind::Partition; })),
    torus.server.Description().partitions);
}

TEST(TestLodSelection, SmallerBudgetsAreCoarser)
{
  Selected torus(DetailMode::View, Torus());
  torus.FollowToTheEnd();
  ViewerStatus status;
  torus.lod.PutInto(status);
  EXPECT_EQ(status.remainingError, 0);
  RefinementOptions few;
  few.triangles = 6000;
  torus.lod.SetBudgets(few, {});
  torus.Follow();
  torus.lod.PutInto(status);
  EXPECT_GT(status.remainingError, 0);
}

TEST(TestLodSelection, WhatANearerViewNeedsIsNotThereYet)
{
  Selected torus(DetailMode::View, Torus());
  torus.FollowToTheEnd();
  const auto next = torus.lod.WantedNext(torus.view);
  EXPECT_FALSE(next.empty());
  for (const BlobId& blob : next)
  {
    EXPECT_GT(torus.lod.BytesOf(blob), 0u);
    EXPECT_FALSE(
      IsOfPiece(blob) && torus.model.pieces.Peek(PieceOfBlob(blob, torus.model.Depths())));
  }
}

}
