// SPDX-License-Identifier: BSD-3-Clause
// A source that keeps its blobs on the disk: what was seen before comes from there, even if the
// server cannot be reached. Step "receive" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/DiskCache.h"
#include "viewer/client/ModelSource.h"

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace kdstream
{

class CachedSource final : public ModelSource
{
public:
  // origin: of the server, without a slash at the end.
  CachedSource(
    std::unique_ptr<ModelSource> server, std::shared_ptr<DiskCache> cache, std::string origin);
  // Opens the source without the server, with the models that the server had when they were last
  // listed. Requests for what is not in the cache fail. Errors: NotFound if the cache has nothing
  // of this server.
  static Result<std::unique_ptr<CachedSource>> Offline(
    std::shared_ptr<DiskCache> cache, std::string origin);

  const std::vector<ModelSummary>& Models() const override { return this->ModelList; }
  void Send(const SessionRequest& request) override;
  void AskForNotes(const std::string& model) override;
  std::vector<ClientEvent> Take() override;
  bool Wait(std::chrono::milliseconds atMost) override;

private:
  CacheKey KeyOf(const std::string& digest, const std::string& name) const;
  void Open(const SessionRequest& request);
  void SendBlobs(const SessionRequest& request);
  void Keep(const ClientEvent& event);

  std::unique_ptr<ModelSource> Server; // null: offline
  std::shared_ptr<DiskCache> Cache;
  std::string Origin;
  std::vector<ModelSummary> ModelList;
  std::string Digest;                         // the digest of the model that was opened last
  std::map<std::uint32_t, std::string> Asked; // requests to the server, with the model's digest
  std::vector<ClientEvent> Found;
};

}
