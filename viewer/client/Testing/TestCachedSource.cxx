// SPDX-License-Identifier: BSD-3-Clause
// What was fetched before comes from the disk, with the server and without it.
#include "Testing/Fixtures/Eventually.h"
#include "viewer/client/CachedSource.h"

#include "viewer/client/LocalClient.h"
#include "viewer/client/Testing/SettledSession.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

using namespace kdstream;
using fixtures::TemporaryFolder;
using kdstream::testing::Settle;
using kdstream::testing::TorusModel;

namespace
{

constexpr int large = 800;

// A source whose partitions arrive with a wrong byte.
class Garbling final : public ModelSource
{
public:
  explicit Garbling(std::unique_ptr<ModelSource> source)
    : Source(std::move(source))
  {
  }
  const std::vector<ModelSummary>& Models() const override { return this->Source->Models(); }
  void Send(const SessionRequest& request) override { this->Source->Send(request); }
  void AskForNotes(const std::string& model) override { this->Source->AskForNotes(model); }
  std::vector<ClientEvent> Take() override
  {
    auto events = this->Source->Take();
    for (ClientEvent& event : events)
    {
      if (event.kind == ClientEvent::Kind::Blob && event.blob.kind == protocol::BlobKind::Partition)
      {
        event.bytes[event.bytes.size() / 2] ^= 1;
      }
    }
    return events;
  }
  bool Wait(std::chrono::milliseconds atMost) override { return this->Source->Wait(atMost); }

private:
  std::unique_ptr<ModelSource> Source;
};

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

  // Shows the whole torus in a window of this width in pixels; returns the number of shown
  // triangles.
  static std::uint64_t ShowWhole(ModelSource& source, ViewerSession& session, int width = 100)
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

TEST_F(TestCachedSource, ASecondViewAsksTheServerForNothing)
{
  ViewerSession first;
  const auto shown = ShowWhole(*this->Online(), first);
  EXPECT_GT(this->Model->TakeRead().size(), 1u);
  EXPECT_FALSE(AllFromCache(first));
  ViewerSession second;
  EXPECT_EQ(ShowWhole(*this->Online(), second), shown);
  EXPECT_EQ(this->Model->TakeRead(), std::vector<std::string>());
  EXPECT_TRUE(AllFromCache(second));
  // A larger window needs more: only the rest is read.
  ViewerSession third;
  ShowWhole(*this->Online(), third, large);
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
    ShowWhole(*source, session, large);
    this->Model->TakeRead();
    tap(session, *source);
    EXPECT_EQ(this->Model->TakeRead().empty(), again);
  }
  // A wider region: some of it is in the cache.
  options.rings = 2;
  const auto source = this->Online();
  ViewerSession session(options);
  ShowWhole(*source, session, large);
  tap(session, *source);
  const auto read = this->Model->TakeRead();
  EXPECT_GT(read.size(), 0u);
  EXPECT_LT(read.size(), session.GetStatus().region->partitions);
}

// Of the blobs of a region, only those that are not in the cache are requested from the server.
TEST_F(TestCachedSource, ARegionIsAskedForWithoutWhatIsKept)
{
  class Listening final : public ModelSource
  {
  public:
    explicit Listening(std::vector<SessionRequest>& heard)
      : Heard(heard)
    {
    }
    const std::vector<ModelSummary>& Models() const override { return this->None; }
    void Send(const SessionRequest& request) override { this->Heard.push_back(request); }
    void AskForNotes(const std::string& /*model*/) override {}
    std::vector<ClientEvent> Take() override { return {}; }
    bool Wait(std::chrono::milliseconds) override { return false; }

  private:
    std::vector<ModelSummary> None;
    std::vector<SessionRequest>& Heard;
  };

  const auto cache = *DiskCache::Open(this->Folder.Path, this->MostBytes);
  const CacheKey third{ "http://a:1", "", "partitions/3" };
  cache->Put(third, { 1, 2, 3 });
  EXPECT_TRUE(fixtures::Eventually([&] { return cache->Find(third); }));
  std::vector<SessionRequest> heard;
  CachedSource source(std::make_unique<Listening>(heard), cache, "http://a:1");
  SessionRequest region;
  region.kind = SessionRequest::Kind::Blobs;
  region.id = 7;
  region.blobs = { protocol::BlobId::Partition(3), protocol::BlobId::Partition(4) };
  source.Send(region);
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].blobs, std::vector<protocol::BlobId>{ protocol::BlobId::Partition(4) });
  const auto found = source.Take();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].blob, protocol::BlobId::Partition(3));
  // A cancel goes to the server for its part of the request, and removes our cached answers.
  source.Send(region);
  SessionRequest cancel;
  cancel.kind = SessionRequest::Kind::Cancel;
  cancel.id = 7;
  source.Send(cancel);
  EXPECT_EQ(heard.back().kind, SessionRequest::Kind::Cancel);
  EXPECT_TRUE(source.Take().empty());
}

TEST_F(TestCachedSource, WithoutTheServerEverythingThatWasSeenIsThere)
{
  ViewerSession before;
  const auto shown = ShowWhole(*this->Online(), before);
  this->Model->TakeRead();
  const auto source = this->Offline();
  ASSERT_TRUE(source);
  ASSERT_EQ((*source)->Models().size(), 1u);
  ViewerSession session;
  EXPECT_EQ(ShowWhole(**source, session), shown);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_TRUE(AllFromCache(session));
  // There is a message about what is not in the cache, and the rest stays.
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

TEST_F(TestCachedSource, WhatComesDamagedIsNotKept)
{
  {
    CachedSource garbled(std::make_unique<Garbling>(std::make_unique<LocalClient>(
                           std::vector<std::shared_ptr<const ServedModel>>{ this->Model })),
      *DiskCache::Open(this->Folder.Path, this->MostBytes), "http://a:1");
    ViewerSession first;
    ShowWhole(garbled, first, large);
    EXPECT_NE(first.GetStatus().error, "");
  }
  this->Model->TakeRead();
  ViewerSession second;
  ShowWhole(*this->Online(), second, large);
  EXPECT_EQ(second.GetStatus().error, "");
  const auto read = this->Model->TakeRead();
  EXPECT_GT(read.size(), 0u);
  EXPECT_TRUE(std::all_of(read.begin(), read.end(),
    [](const std::string& name) { return name.rfind("partitions/", 0) == 0; }));
}

TEST_F(TestCachedSource, ACacheThatKeepsNothingIsStillAWayToTheServer)
{
  this->MostBytes = 0;
  for (int i = 0; i < 2; ++i)
  {
    ViewerSession session;
    EXPECT_GT(ShowWhole(*this->Online(), session), 4000u);
    EXPECT_GT(this->Model->TakeRead().size(), 1u);
  }
}

}
