// SPDX-License-Identifier: BSD-3-Clause
// A server without memory for a connection loses only that connection: it continues to listen.
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/HttpServer.h"
#include "server/http/ServerState.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/http/Testing/ScarceMemory.h"
#include "server/session/Testing/MemoryCatalog.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

// A model whose readers run out of memory after they have read a blob.
class ScarceModel : public MemoryModel
{
public:
  using MemoryModel::MemoryModel;
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    auto bytes = this->MemoryModel::ReadBlob(blob);
    ScarceMemory::FailHere(this->failing);
    return bytes;
  }
  std::atomic<long> failing{ -1 }; // which allocation fails
};

std::unique_ptr<HttpServer> Start(const Catalog& catalog)
{
  HttpServerOptions options;
  options.threads = 1;
  options.drainTimeout = std::chrono::milliseconds(0);
  auto server = HttpServer::Start(catalog, options);
  return server ? std::move(*server) : nullptr;
}

}

// One server after the other: in each, another allocation of accepting a client fails. The last is
// that of the connection's object, which is known by its size: more than 4096 bytes.
TEST(MemoryRunsOut, TheServerGoesOnListening)
{
  const MemoryCatalog catalog;
  constexpr std::size_t connectionBytes = 4096;
  long tried = 0;
  for (std::size_t failed = 0; failed < connectionBytes; ++tried)
  {
    const auto server = Start(catalog); // a new one, in which nothing else happens
    ASSERT_TRUE(server);
    {
      const ScarceMemory scarce(tried, ScarceMemory::Where::OtherThreads);
      HttpTestClient lost(server->Port());
      failed = scarce.AwaitFailure();
      EXPECT_TRUE(lost.Ends());
    }
    const auto answer = HttpTestClient(server->Port()).Get("/healthz");
    ASSERT_TRUE(answer) << "allocation " << tried;
    EXPECT_EQ(answer->status, 200u);
  }
  EXPECT_GT(tried, 2);
}

TEST(MemoryRunsOut, ASlotIsGivenBack)
{
  const MemoryCatalog catalog;
  HttpServerOptions options;
  options.maximumConnections = 1;
  ServerState state(catalog, options);
  {
    const ScarceMemory scarce(0, ScarceMemory::Where::Everywhere);
    EXPECT_THROW(state.TakeSlot(), std::bad_alloc);
  }
  const auto slot = state.TakeSlot();
  EXPECT_TRUE(slot);
  EXPECT_FALSE(state.TakeSlot());
}

// A reader's result gets back to the connection, whichever of the reader's allocations fails. If a
// reader ended the connection itself, it would do so while the connection's thread uses the socket.
TEST(MemoryRunsOut, WhatWasReadIsAnswered)
{
  MemoryCatalog catalog;
  const auto model = std::make_shared<ScarceModel>("dragon", 1, 4, 100);
  catalog.models["dragon"] = model;
  const auto server = Start(catalog);
  ASSERT_TRUE(server);
  const auto target =
    protocol::BlobPath("dragon", model->Description().digest, protocol::BlobId::Partition(3));
  constexpr long enough = 60; // more allocations than a reader makes
  for (long failing = 0; failing < enough; ++failing)
  {
    model->failing = failing;
    EXPECT_TRUE(HttpTestClient(server->Port()).Get(target)) << "allocation " << failing;
    StreamTestClient client(server->Port());
    ASSERT_TRUE(client.Open());
    client.Ask({ 1, protocol::OpenRequest{ "dragon" } });
    EXPECT_TRUE(client.Await(1).opened);
    client.Ask({ 2, protocol::AskPartitions({ 3 }) });
    const auto answer = client.Await(2);
    ASSERT_TRUE(answer.end) << "allocation " << failing;
    EXPECT_EQ(answer.blobs.size(), 1u) << "allocation " << failing;
    client.Close();
  }
}
