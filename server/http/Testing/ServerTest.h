// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the server share: a server on real sockets, with one model made up in memory.
#pragma once

#include "Testing/Fixtures/Eventually.h"
#include "filters/core/tree/Region.h"
#include "filters/protocol/ResourcePath.h"
#include "server/http/HttpServer.h"
#include "server/http/Testing/HttpTestClient.h"
#include "server/session/Testing/MemoryCatalog.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace kdstream
{

class ServerTest : public testing::Test
{
protected:
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 7, 20000);
  HttpServerOptions options = Hasty();
  std::mutex mutex;
  std::vector<AccessRecord> records;
  std::unique_ptr<HttpServer> server;

  std::uint16_t Start()
  {
    this->options.onAccess = [this](const AccessRecord& record)
    {
      const std::lock_guard lock(this->mutex);
      this->records.push_back(record);
    };
    auto started = HttpServer::Start(this->catalog, this->options);
    EXPECT_TRUE(started) << started.GetError().message;
    this->server = std::move(*started);
    return this->server->Port();
  }

  // The record of a request for `target`, once there is one.
  AccessRecord AwaitRecord(const std::string& target)
  {
    AccessRecord found;
    const auto isThere = [&]
    {
      const std::lock_guard lock(this->mutex);
      const auto record = std::find_if(this->records.begin(), this->records.end(),
        [&](const AccessRecord& each) { return each.target == target; });
      const bool is = record != this->records.end();
      found = is ? *record : AccessRecord();
      return is;
    };
    EXPECT_TRUE(fixtures::Eventually(isThere)) << "there is no record of " << target;
    return found;
  }

  // Options for a server that, when it ends, waits only briefly for its clients.
  static HttpServerOptions Hasty()
  {
    HttpServerOptions hasty;
    hasty.drainTimeout = std::chrono::milliseconds(500);
    return hasty;
  }

  std::uint16_t AdminPort() const
  {
    const auto url = this->server->AdminUrl();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }

  static bool MetricsHave(const std::string& line, HttpTestClient& client)
  {
    const auto metrics = client.Get("/metrics");
    return metrics && metrics->body.find(line) != std::string::npos;
  }

  std::string Blob(const protocol::BlobId& id) const
  {
    return protocol::BlobPath("dragon", this->model->Description().digest, id);
  }

  std::vector<std::uint32_t> Region(std::uint32_t cell, unsigned rings) const
  {
    return *FindRegion(this->model->TrueBoxes(), this->model->GetDepths(), cell, rings);
  }

  // Whether the answer's blobs are those of the region, in order, byte for byte.
  bool IsRegion(const StreamTestClient::Answer& answer, std::uint32_t cell, unsigned rings) const
  {
    const auto region = this->Region(cell, rings);
    bool good = answer.end && answer.blobs.size() == region.size();
    for (std::size_t i = 0; good && i < region.size(); ++i)
    {
      const auto id = protocol::BlobId::Partition(region[i]);
      good = answer.blobs[i].id == id && answer.blobs[i].bytes == *this->model->blobs.at(id);
    }
    return good;
  }
};

}
