// SPDX-License-Identifier: BSD-3-Clause
// The list of wanted blobs: the order of requests, how much at a time, what is cancelled, and what
// is prefetched.
#include "viewer/session/requests/WishList.h"

#include <gtest/gtest.h>

using namespace kdstream;
using protocol::BlobId;
using Kind = SessionRequest::Kind;

namespace
{

constexpr std::size_t blobBytes = 8 * 1024; // of each blob; at first 64 KiB are in flight
std::size_t BytesOf(const BlobId& /*blob*/)
{
  return blobBytes;
}
constexpr BlobId preview = BlobId::LevelPiece(11, 1);

std::vector<BlobId> Partitions(std::uint32_t begin, std::uint32_t end)
{
  std::vector<BlobId> blobs;
  for (std::uint32_t number = begin; number < end; ++number)
  {
    blobs.push_back(BlobId::Partition(number));
  }
  return blobs;
}

std::vector<BlobId> BlobsOf(const std::vector<SessionRequest>& requests)
{
  std::vector<BlobId> blobs;
  for (const SessionRequest& request : requests)
  {
    EXPECT_EQ(request.kind, Kind::Blobs);
    blobs.insert(blobs.end(), request.blobs.begin(), request.blobs.end());
  }
  return blobs;
}

TEST(TestWishList, AsMuchIsAskedForAsFillsTheLineInItsOrder)
{
  WishList list(0);
  EXPECT_TRUE(list.IsIdle());
  list.Want(Partitions(0, 30));
  EXPECT_FALSE(list.IsIdle());
  list.AskMore(BytesOf, { preview });
  const auto first = list.TakeOutgoing();
  ASSERT_EQ(first.size(), 4u);
  EXPECT_EQ(first[0].blobs.size(), 2u) << "a quarter of what may be under way";
  EXPECT_EQ(BlobsOf(first), Partitions(0, 8));
  EXPECT_EQ(list.GetProgress().blobsWanted, 30u);
  list.AskMore(BytesOf, { preview });
  EXPECT_TRUE(list.TakeOutgoing().empty()) << "the line is full";

  for (const SessionRequest& request : first)
  {
    for (const BlobId& blob : request.blobs)
    {
      EXPECT_TRUE(list.Arrived(request.id, blob, blobBytes, 0, false));
      EXPECT_FALSE(list.Arrived(request.id, blob, blobBytes, 0, false)) << "once";
    }
  }
  list.AskMore(BytesOf, { preview });
  EXPECT_EQ(BlobsOf(list.TakeOutgoing()), Partitions(8, 16));
  EXPECT_EQ(list.GetProgress().blobsLoaded, 8u);
  EXPECT_EQ(list.GetProgress().blobsWanted, 30u);
  EXPECT_EQ(list.GetProgress().bytesLoaded, 8 * blobBytes);
}

TEST(TestWishList, WhatNobodyWantsIsCancelledAndNothingIsAskedForTwice)
{
  WishList list(0);
  list.Want(Partitions(0, 8));
  list.AskMore(BytesOf, { preview });
  const auto asked = list.TakeOutgoing();
  list.Want({ BlobId::Partition(1), BlobId::Partition(20) });
  list.AskMore(BytesOf, { preview });
  std::vector<std::uint32_t> cancelled;
  std::vector<BlobId> more;
  for (const SessionRequest& request : list.TakeOutgoing())
  {
    request.kind == Kind::Cancel ? cancelled.push_back(request.id) : void();
    more.insert(more.end(), request.blobs.begin(), request.blobs.end());
  }
  EXPECT_EQ(cancelled, (std::vector{ asked[1].id, asked[2].id, asked[3].id }))
    << "not the one that brings something of it";
  EXPECT_EQ(more, std::vector{ BlobId::Partition(20) });
  EXPECT_FALSE(list.Arrived(asked[3].id, asked[3].blobs[0], blobBytes, 0, false));
  EXPECT_TRUE(list.TakeLate(asked[3].id, asked[3].blobs[0]));
  EXPECT_TRUE(list.Failed(asked[0].id, BlobId::Partition(0)));
  EXPECT_EQ(list.Close(asked[0].id), std::vector{ BlobId::Partition(1) });
}

TEST(TestWishList, ThePreviewIsRequestedByItselfAndTheTreeOnlyForATap)
{
  WishList list(0);
  list.Want({ preview, BlobId::LevelPiece(12, 2), BlobId::LevelPiece(12, 3) });
  EXPECT_EQ(list.AskMore(BytesOf, { preview }), 0u);
  const auto requests = list.TakeOutgoing();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].blobs, std::vector{ preview });

  WishList tap(0);
  tap.Want({ BlobId::TreePage(1), BlobId::PartitionBoxes(4), BlobId::Partition(1) });
  EXPECT_EQ(tap.AskMore(BytesOf, { preview, true }), 2u);
  EXPECT_EQ(BlobsOf(tap.TakeOutgoing()).size(), 2u);
  tap.AskMore(BytesOf, { preview });
  EXPECT_EQ(BlobsOf(tap.TakeOutgoing()), std::vector{ BlobId::Partition(1) });
  tap.Want(
    { BlobId::TreePage(1), BlobId::PartitionBoxes(4), BlobId::Partition(1), BlobId::Texture(1) });
  tap.AskMore(BytesOf, { preview });
  EXPECT_EQ(BlobsOf(tap.TakeOutgoing()), std::vector{ BlobId::Texture(1) });
  tap.KeepTreeOnly(); // a second tap
  const auto cancels = tap.TakeOutgoing();
  ASSERT_EQ(cancels.size(), 2u);
  EXPECT_EQ(cancels[0].kind, Kind::Cancel);
  EXPECT_TRUE(tap.Book().IsOutstanding(BlobId::TreePage(1)));
  EXPECT_FALSE(tap.Book().IsOutstanding(BlobId::Partition(1)));
  EXPECT_FALSE(tap.Book().IsOutstanding(BlobId::Texture(1)));
}

// Because a server whose quota is used up refuses a request as a whole.
TEST(TestWishList, TheOriginalIsAskedForApartWhereThatIsWanted)
{
  const std::vector<BlobId> wanted{ BlobId::Partition(1), BlobId::LevelPiece(12, 2),
    BlobId::LevelPiece(12, 3), BlobId::Texture(1), BlobId::Texture(2) };
  for (const bool apart : { false, true })
  {
    WishList list(0);
    list.Want(wanted);
    list.AskMore(BytesOf, { preview, false, apart });
    const auto requests = list.TakeOutgoing();
    EXPECT_EQ(BlobsOf(requests), wanted);
    std::size_t mixed = 0;
    for (const SessionRequest& request : requests)
    {
      mixed += IsOfOriginal(request.blobs.front()) != IsOfOriginal(request.blobs.back()) ? 1 : 0;
    }
    EXPECT_EQ(mixed, apart ? 0u : 2u);
  }
}

TEST(TestWishList, PrefetchIsNotProgressAndMakesWayAndEnds)
{
  const std::vector<PieceId> view{ { Resolution::Level(12), 2 } };
  WishList list(3 * blobBytes);
  ASSERT_TRUE(list.MayPrefetch(view));
  list.Prefetch(Partitions(0, 9), BytesOf);
  EXPECT_EQ(BlobsOf(list.TakeOutgoing()), Partitions(0, 3)) << "so many bytes of a view";
  EXPECT_TRUE(list.IsIdle());
  EXPECT_FALSE(list.IsEmpty());
  EXPECT_FALSE(list.MayPrefetch(view));
  list.Want({});
  EXPECT_TRUE(list.TakeOutgoing().empty()) << "it goes on";
  EXPECT_TRUE(list.IsPrefetched(BlobId::Partition(2)));
  list.Want({ BlobId::Partition(40) });
  const auto cancels = list.TakeOutgoing();
  ASSERT_EQ(cancels.size(), 1u);
  EXPECT_EQ(cancels[0].kind, Kind::Cancel) << "it makes way";
  EXPECT_FALSE(list.IsIdle());

  WishList none(0);
  EXPECT_FALSE(none.MayPrefetch(view));
  none.SetPrefetch(blobBytes);
  ASSERT_TRUE(none.MayPrefetch(view));
  none.Prefetch(Partitions(0, 1), BytesOf);
  EXPECT_TRUE(none.GiveUpPrefetch(BlobId::Partition(0)));
  EXPECT_FALSE(none.GiveUpPrefetch(BlobId::Partition(0)));
  none.CloseModel();
  EXPECT_TRUE(none.IsEmpty());
}

}
