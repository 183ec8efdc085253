// SPDX-License-Identifier: BSD-3-Clause
// What was seen before comes from the disk, with the server and without it.
#include "viewer/client/CachedSource.h"

#include "viewer/client/LocalClient.h"
#include "viewer/client/Testing/SettledSession.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace kdstream;
using fixtures::TemporaryFolder;
using kdstream::testing::Settle;
using kdstream::testing::TorusModel;

namespace
{

constexpr int large = 800;

class TestCachedSource : public ::testing::Test
{
protected:
  std::unique_ptr<CachedSource> Online()
  {
    return std::make_unique<CachedSource>(
      std::make_unique<LocalClient>(std::vector<std::shared_ptr<const ServedModel>>{ this->Model }),
      *DiskCache::Open(this->Folder.Path, this->MostBytes), "http://a:1");
  }
  Result<std::unique_ptr<CachedSource>> Offline(const std::string& origin = "http://a:1")
  {
    return CachedSource::Offline(*DiskCache::Open(this->Folder.Path, this->MostBytes), origin);
  }

  // Looks at the whole torus, in a window of so many pixels; the triangles that are shown.
  static std::uint64_t Look(ModelSource& source, ViewerSession& session, int width = 100)
  {
    session.Resize({ width, width * 3 / 4, 1 });
    session.SetModels(source.Models());
    EXPECT_TRUE(session.SelectModel("torus"));
    session.EnterFullScreen();
    EXPECT_TRUE(Settle(session, source));
    return session.GetStatus().triangles;
  }

  static bool AllFromCache(const ViewerSession& session)
  {
    return std::all_of(session.Statistics().begin(), session.Statistics().end(),
      [](const BlobStatistics& blob) { return blob.fromCache; });
  }

  TemporaryFolder Folder;
  std::uint64_t MostBytes = std::uint64_t{ 1 } << 30;
  std::shared_ptr<TorusModel> Model = std::make_shared<TorusModel>();
};

TEST_F(TestCachedSource, ASecondLookAsksTheServerForNothing)
{
  ViewerSession first;
  const auto shown = Look(*this->Online(), first);
  EXPECT_GT(this->Model->TakeRead().size(), 1u);
  EXPECT_FALSE(AllFromCache(first));
  ViewerSession second;
  EXPECT_EQ(Look(*this->Online(), second), shown);
  EXPECT_EQ(this->Model->TakeRead(), std::vector<std::string>());
  EXPECT_TRUE(AllFromCache(second));
  // In a larger window: the rest.
  ViewerSession third;
  Look(*this->Online(), third, large);
  const auto more = this->Model->TakeRead();
  EXPECT_GT(more.size(), 0u);
  EXPECT_LT(more.size(), third.Statistics().size());
}

TEST_F(TestCachedSource, ARegionIsAskedForWithoutWhatIsThere)
{
  SessionOptions options;
  options.detail = DetailMode::Level;
  const auto tap = [](ViewerSession& session, ModelSource& source)
  {
    for (const double time : { 1.0, 1.2 })
    {
      session.HandleTouches({ time, { { 1, large / 2, 440.0 } } });
      session.HandleTouches({ time + 0.05, {} });
    }
    EXPECT_TRUE(Settle(session, source));
    EXPECT_TRUE(session.GetStatus().region);
    EXPECT_EQ(session.GetStatus().region->shown, session.GetStatus().region->partitions);
  };
  for (const bool again : { false, true })
  {
    const auto source = this->Online();
    ViewerSession session(options);
    Look(*source, session, large);
    this->Model->TakeRead();
    tap(session, *source);
    EXPECT_EQ(this->Model->TakeRead().empty(), again);
  }
  // Some of it: a wider region.
  options.rings = 2;
  const auto source = this->Online();
  ViewerSession session(options);
  Look(*source, session, large);
  tap(session, *source);
  const auto read = this->Model->TakeRead();
  EXPECT_GT(read.size(), 0u);
  EXPECT_LT(read.size(), session.GetStatus().region->partitions);
}

TEST_F(TestCachedSource, WithoutTheServerEverythingThatWasSeenIsThere)
{
  ViewerSession before;
  const auto shown = Look(*this->Online(), before);
  this->Model->TakeRead();
  const auto source = this->Offline();
  ASSERT_TRUE(source);
  ASSERT_EQ((*source)->Models().size(), 1u);
  ViewerSession session;
  EXPECT_EQ(Look(**source, session), shown);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_TRUE(AllFromCache(session));
  // What was not seen is said not to be there, and the rest stays.
  session.Resize({ large, large * 3 / 4, 1 });
  EXPECT_TRUE(Settle(session, **source));
  EXPECT_NE(session.GetStatus().error.find("http://a:1 cannot be reached"), std::string::npos)
    << session.GetStatus().error;
  EXPECT_GT(session.GetStatus().triangles, 0u);
  EXPECT_TRUE(this->Model->TakeRead().empty());

  const auto never = this->Offline("http://b:1");
  ASSERT_FALSE(never);
  EXPECT_EQ(never.GetError().code, ErrorCode::NotFound);
}

TEST_F(TestCachedSource, WhatTheServerSendsDamagedIsNotKept)
{
  this->Model->damaged = protocol::BlobId::Partition(0);
  ViewerSession first;
  Look(*this->Online(), first, large);
  this->Model->damaged.reset();
  this->Model->TakeRead();
  ViewerSession second;
  Look(*this->Online(), second, large);
  EXPECT_EQ(second.GetStatus().error, "");
}

TEST_F(TestCachedSource, ACacheThatKeepsNothingIsStillAWayToTheServer)
{
  this->MostBytes = 0;
  for (int i = 0; i < 2; ++i)
  {
    ViewerSession session;
    EXPECT_GT(Look(*this->Online(), session), 4000u);
    EXPECT_GT(this->Model->TakeRead().size(), 1u);
  }
}

}
