// SPDX-License-Identifier: BSD-3-Clause
// Blobs of a model that cannot be fetched: which are requested again, and what is reported.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/model/FailedBlobs.h"

#include <gtest/gtest.h>

using namespace kdstream;
using protocol::BlobId;

namespace
{

const TreeDepths depths{ 7, 13 };
const BlobId page = BlobId::TreePage(1), partition = BlobId::Partition(3);

PieceId PieceOf(const BlobId& blob)
{
  return PieceOfBlob(blob, depths);
}

FailedBlobs OfTorus()
{
  FailedBlobs failed;
  failed.SetModel("torus");
  return failed;
}

TEST(TestFailedBlobs, WhatFailedIsReportedAndNotAskedForBeforeRetry)
{
  FailedBlobs failed = OfTorus();
  failed.Add(page, {}, "it is damaged", false);
  EXPECT_TRUE(fixtures::Mentions(failed.Message(), { "tree/1 ", "torus", "it is damaged" }));
  failed.Add(partition, PieceOf(partition), "it is damaged", false);
  EXPECT_TRUE(failed.Has(page));
  EXPECT_TRUE(failed.Has(PieceOf(partition)));
  failed.Retry();
  EXPECT_FALSE(failed.Has(page));
  EXPECT_FALSE(failed.Has(PieceOf(partition)));
  EXPECT_EQ(failed.Message(), "");
}

TEST(TestFailedBlobs, WhatMayBeDoneWithoutIsReportedOnceItIsMissed)
{
  FailedBlobs failed = OfTorus();
  failed.Add(partition, PieceOf(partition), "it is damaged", true);
  EXPECT_TRUE(failed.Has(PieceOf(partition)));
  EXPECT_EQ(failed.Message(), "");
  failed.ReportMissed([](PieceId) { return false; });
  EXPECT_EQ(failed.Message(), "");
  failed.ReportMissed([](PieceId piece) { return piece == PieceOf(partition); });
  EXPECT_TRUE(fixtures::Mentions(failed.Message(), { "partitions/3 ", "torus", "it is damaged" }));
}

TEST(TestFailedBlobs, WhatWasLostIsAskedForAgainOnceTheConnectionIsBack)
{
  FailedBlobs failed = OfTorus();
  for (const BlobId& blob : { page, partition })
  {
    failed.AddLost(blob, "the connection is lost");
    failed.Add(blob, IsOfPiece(blob) ? std::optional(PieceOf(blob)) : std::nullopt,
      "the connection is lost", false);
  }
  const auto again = failed.TakeLost(BlobId::Partition(9), depths);
  EXPECT_EQ(again, (std::vector{ page, partition }));
  EXPECT_FALSE(failed.Has(page));
  EXPECT_FALSE(failed.Has(PieceOf(partition)));
  EXPECT_EQ(failed.Message(), "");

  // Lost again: it waits until one of the repeated blobs has arrived, so that repeating ends.
  failed.AddLost(partition, "the connection is lost");
  EXPECT_TRUE(failed.TakeLost(BlobId::Partition(9), depths).empty());
  EXPECT_EQ(failed.TakeLost(page, depths), std::vector{ partition });
}

TEST(TestFailedBlobs, TheNextLossIsOneByItself)
{
  FailedBlobs failed = OfTorus();
  failed.AddLost(partition, "the connection is lost");
  EXPECT_EQ(failed.TakeLost(page, depths).size(), 1u);
  failed.SettleAll(); // everything has arrived
  failed.AddLost(partition, "the connection is lost");
  EXPECT_EQ(failed.TakeLost(page, depths).size(), 1u);

  // A blob that has failed by itself is not waited for.
  failed.Settle(partition);
  failed.AddLost(partition, "the connection is lost");
  EXPECT_EQ(failed.TakeLost(page, depths).size(), 1u);
}

}
