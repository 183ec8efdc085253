// SPDX-License-Identifier: BSD-3-Clause
// Stores on this machine as a session's source.
#include "viewer/client/LocalClient.h"
#include "viewer/client/Testing/SettledSession.h"
#include "viewer/client/Testing/TorusCatalog.h"
#include "viewer/session/ViewerSession.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;
using fixtures::TemporaryFolder;
using kdstream::testing::Settle;
using kdstream::testing::TorusModel;

namespace
{

std::shared_ptr<TorusModel> Named(const std::string& id)
{
  auto model = std::make_shared<TorusModel>();
  model->described = kdstream::testing::ServedTorus().Description();
  model->described->id = id;
  return model;
}

TEST(TestLocalClient, ShowsOneModelAfterTheOther)
{
  LocalClient source({ Named("a"), Named("b") });
  ASSERT_EQ(source.Models().size(), 2u);
  EXPECT_EQ(source.Models()[1].id, "b");
  ViewerSession session;
  session.Resize({ 800, 600, 1 });
  session.SetModels(source.Models());
  for (const std::string id : { "a", "b", "a" })
  {
    ASSERT_TRUE(session.SelectModel(id));
    ASSERT_TRUE(Settle(session, source));
    session.EnterFullScreen();
    ASSERT_TRUE(Settle(session, source));
    EXPECT_GT(session.GetStatus().triangles, 4000u);
    EXPECT_EQ(session.GetStatus().error, "");
    EXPECT_EQ(session.GetStatus().model, id);
  }
}

TEST(TestLocalClient, WhatIsDamagedOrNotThereIsReported)
{
  const auto model = Named("a");
  const TreeDepths depths = model->Description().depths;
  model->damaged =
    protocol::BlobId::LevelPiece(static_cast<std::uint8_t>(PreviewLevel(model->Description())), 1);
  LocalClient source({ model });
  ViewerSession session;
  session.SetModels(source.Models());
  ASSERT_TRUE(session.SelectModel("a"));
  ASSERT_TRUE(Settle(session, source));
  EXPECT_NE(session.GetStatus().error.find("its checksum is wrong"), std::string::npos)
    << session.GetStatus().error << depths.finest;

  ViewerSession unknowing; // it has not been given the list
  ASSERT_TRUE(unknowing.SelectModel("nobody"));
  ASSERT_TRUE(Settle(unknowing, source));
  EXPECT_NE(unknowing.GetStatus().error.find("nobody"), std::string::npos);
}

struct ModelWithoutMemory final : TorusModel
{
  Result<BlobBytes> ReadBlob(const protocol::BlobId& /*blob*/) const override
  {
    throw std::bad_alloc();
  }
};

TEST(TestLocalClient, OnlyTheBlobForWhichThereIsNoMemoryFails)
{
  const auto model = std::make_shared<ModelWithoutMemory>();
  model->described = kdstream::testing::ServedTorus().Description();
  model->described->id = "a";
  LocalClient source({ model });
  SessionRequest request;
  request.id = 1;
  request.model = "a";
  source.Send(request);
  request.kind = SessionRequest::Kind::Blobs;
  request.id = 2;
  request.blobs = { protocol::BlobId::TreePage(1), protocol::BlobId::Partition(0) };
  source.Send(request);
  std::vector<ClientEvent> events;
  while (events.size() < 3 && source.Wait(std::chrono::seconds(60)))
  {
    for (ClientEvent& event : source.Take())
    {
      events.push_back(std::move(event));
    }
  }
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, ClientEvent::Kind::Opened);
  for (std::size_t i = 0; i < 2; ++i)
  {
    EXPECT_EQ(events[i + 1].kind, ClientEvent::Kind::BlobFailed);
    EXPECT_EQ(events[i + 1].request, 2u);
    EXPECT_EQ(events[i + 1].blob, request.blobs[i]);
    EXPECT_EQ(events[i + 1].message, "out of memory");
  }
}

TEST(TestLocalClient, WhatIsCancelledDoesNotCome)
{
  const auto model = Named("a");
  LocalClient source({ model });
  SessionRequest open;
  open.id = 1;
  open.model = "a";
  source.Send(open);
  SessionRequest all;
  all.kind = SessionRequest::Kind::Blobs;
  all.id = 2;
  for (std::uint32_t i = 0; i < 100'000; ++i)
  {
    all.blobs.push_back(protocol::BlobId::Partition(i));
  }
  source.Send(all);
  SessionRequest cancel;
  cancel.kind = SessionRequest::Kind::Cancel;
  cancel.id = 2;
  source.Send(cancel);
  all.id = 3;
  all.blobs.resize(1);
  source.Send(all);
  std::size_t cancelled = 0;
  for (bool last = false; !last;)
  {
    ASSERT_TRUE(source.Wait(std::chrono::seconds(20)));
    for (const ClientEvent& event : source.Take())
    {
      cancelled += event.request == 2 ? 1 : 0;
      last |= event.request == 3;
    }
  }
  EXPECT_LT(cancelled, 100'000u);
}

TEST(TestLocalClient, WhatIsNotAStoreIsRefused)
{
  const TemporaryFolder folder;
  const auto empty = LocalClient::Open(folder.Path);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.GetError().code, ErrorCode::NotFound);
  EXPECT_NE(empty.GetError().message.find("no stores (.kds)"), std::string::npos);
  std::ofstream(folder / "m.kds") << "SQLite format 3";
  for (const auto& path : { folder.Path, folder / "m.kds" })
  {
    const auto opened = LocalClient::Open(path);
    ASSERT_FALSE(opened) << path;
    EXPECT_FALSE(opened.GetError().message.empty());
  }
  EXPECT_NE(LocalClient::Open(folder.Path).GetError().message.find("m.kds: "), std::string::npos);
}

}
