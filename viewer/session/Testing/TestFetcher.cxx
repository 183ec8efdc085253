// SPDX-License-Identifier: BSD-3-Clause
// The Fetcher by itself: its requests, and what it does with answers.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/Fetcher.h"
#include "viewer/session/Testing/TorusModel.h"

#include <gtest/gtest.h>

#include <tuple>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;

namespace
{

struct Fetched : TorusModel
{
  LodSelection lod{ this->model, {} };
  PickedRegion region{ this->model, 1, {}, 1'000'000 };
  Fetcher fetcher{ this->model, this->lod, this->region, 0, {}, 1000 };
  Camera camera;
  LodSelection::View view{ this->camera, true };

  Fetched()
    : TorusModel(Torus())
  {
    this->camera.SetViewport({ width, height, 1 });
    this->camera.FitTo(this->server.Description().box);
    this->lod.Open();
  }
  void Update()
  {
    while (this->fetcher.Update(this->view))
    {
    }
  }
  // The first blob in flight, and its request.
  std::pair<BlobId, std::uint32_t> Next() const
  {
    return *this->fetcher.Wishes().Book().AllOutstanding().begin();
  }
  Fetcher::Answer Answer(const BlobId& blob, std::uint32_t request)
  {
    return this->fetcher.BlobArrived(request, blob, this->server.Blob(blob), 0.25, false);
  }
  void Draw()
  {
    ASSERT_TRUE(this->model.surface.Draw(this->model.pieces));
    this->fetcher.History().BeginFrame(this->model.surface.Pieces());
  }
  void Settle()
  {
    this->Update();
    while (!this->fetcher.Wishes().IsIdle() || this->lod.IsDue())
    {
      if (this->fetcher.Wishes().IsEmpty())
      {
        if (this->fetcher.FollowView(this->view))
        {
          this->Update();
        }
        continue;
      }
      const auto [blob, request] = this->Next();
      EXPECT_TRUE(this->Answer(blob, request).isNews);
      this->Update();
      this->Draw();
    }
  }
};

TEST(TestFetcher, AsksForTheModelThenForWhatTheViewNeeds)
{
  Fetched torus;
  torus.fetcher.Select("torus");
  const auto opens = torus.fetcher.Wishes().TakeOutgoing();
  ASSERT_EQ(opens.size(), 1u);
  EXPECT_EQ(opens[0].kind, SessionRequest::Kind::Open);
  EXPECT_EQ(opens[0].model, "torus");
  EXPECT_FALSE(torus.fetcher.Wishes().Opened(opens[0].id + 1));
  EXPECT_TRUE(torus.fetcher.Wishes().Opened(opens[0].id));
  torus.Update();
  EXPECT_EQ(
    torus.fetcher.Wishes().TakeOutgoing().at(0).blobs, std::vector{ torus.model.PreviewBlob() });
  torus.Settle();
  EXPECT_GT(torus.model.Drawn().TriangleCount(), 4000u);
  const SessionTraffic& traffic = torus.fetcher.History().Traffic();
  EXPECT_GT(traffic.blobs, 5u);
  EXPECT_LT(traffic.wasted, traffic.bytes / 4); // pieces that were never shown
  EXPECT_EQ(torus.fetcher.History().Entries().front().what, "preview");
}

TEST(TestFetcher, WhatComesUnaskedIsIgnored)
{
  Fetched torus;
  torus.Update();
  const auto answer = torus.Answer(BlobId::Partition(1), 77);
  EXPECT_EQ(answer.arrival, BlobArrival::Unwanted);
  EXPECT_FALSE(answer.isNews);
  EXPECT_EQ(
    torus.fetcher.History().Traffic().wasted, torus.server.Blob(BlobId::Partition(1)).size());
  EXPECT_FALSE(torus.fetcher.BlobFailed(77, BlobId::Partition(1), "it is damaged"));
  EXPECT_FALSE(torus.fetcher.RequestFailed(77, "it is damaged"));
}

TEST(TestFetcher, WhatComesAfterItWasCancelledIsKept)
{
  Fetched torus;
  torus.Update();
  const auto [preview, first] = torus.Next();
  torus.Answer(preview, first);
  torus.Update();
  torus.fetcher.Wishes().TakeOutgoing(); // the requests are sent
  BlobId piece{};
  std::uint32_t request = 0;
  while (!IsOfPiece(piece)) // pages of the tree come first
  {
    std::tie(piece, request) = torus.Next();
    if (!IsOfPiece(piece))
    {
      torus.Answer(piece, request);
      torus.Update();
      torus.Draw();
      torus.fetcher.FollowView(torus.view);
      torus.fetcher.Wishes().TakeOutgoing();
    }
  }
  torus.fetcher.GiveWayToTap();
  const auto answer = torus.Answer(piece, request);
  EXPECT_EQ(answer.arrival, BlobArrival::Taken);
  EXPECT_STREQ(answer.input, "late");
  EXPECT_TRUE(torus.model.pieces.Peek(PieceOfBlob(piece, torus.model.Depths())));
}

TEST(TestFetcher, DamagedBytesFailAndAreNotAskedForAgain)
{
  Fetched torus;
  torus.Update();
  const auto [preview, request] = torus.Next();
  torus.server.Blob(preview).resize(10);
  EXPECT_EQ(torus.Answer(preview, request).arrival, BlobArrival::Damaged);
  EXPECT_NE(torus.model.failed.Message(), "");
  torus.Update();
  EXPECT_FALSE(torus.fetcher.Wishes().Book().IsOutstanding(preview));
  torus.model.Retry();
  torus.Update();
  EXPECT_TRUE(torus.fetcher.Wishes().Book().IsOutstanding(preview));
}

TEST(TestFetcher, WhatWasLostIsAskedForAgainOnceSomethingComes)
{
  Fetched torus;
  torus.Settle();
  torus.lod.SetDetail(DetailMode::Full);
  torus.Update();
  const auto& outstanding = torus.fetcher.Wishes().Book().AllOutstanding();
  const auto [lost, request] = *outstanding.begin();
  const auto [next, other] = *outstanding.rbegin();
  ASSERT_NE(request, other);
  EXPECT_TRUE(torus.fetcher.RequestFailed(request, "the connection is lost"));
  EXPECT_TRUE(torus.model.failed.Has(PieceOfBlob(lost, torus.model.Depths())));
  torus.Update();
  EXPECT_FALSE(torus.fetcher.Wishes().Book().IsOutstanding(lost));
  torus.Answer(next, other);
  EXPECT_FALSE(torus.model.failed.Has(PieceOfBlob(lost, torus.model.Depths())));
  EXPECT_EQ(torus.model.failed.Message(), "");
}

TEST(TestFetcher, SaysThatAModelCannotBeOpened)
{
  Fetched torus;
  torus.fetcher.Select("torus");
  const auto opens = torus.fetcher.Wishes().TakeOutgoing();
  EXPECT_TRUE(torus.fetcher.RequestFailed(opens.back().id, "no such model"));
  EXPECT_TRUE(fixtures::Mentions(torus.model.failed.Message(), { "torus", "no such model" }));
}

TEST(TestFetcher, ATapEndsWhereItsTreeFails)
{
  Fetched torus;
  torus.Settle();
  torus.region.PickAt({ 1, 0, 0.3 });
  torus.fetcher.GiveWayToTap();
  torus.region.Follow(true);
  torus.Update();
  ASSERT_TRUE(torus.region.IsPicking());
  const auto [blob, request] = torus.Next();
  ASSERT_TRUE(IsOfTree(blob));
  EXPECT_TRUE(torus.fetcher.BlobFailed(request, blob, "it is damaged"));
  EXPECT_FALSE(torus.region.IsPicking());
}

}
