// SPDX-License-Identifier: BSD-3-Clause
// A server as a session's source, with a cache on the disk. Step "receive" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "viewer/client/DiskCache.h"
#include "viewer/client/ModelSource.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

struct ConnectedServer
{
  std::unique_ptr<ModelSource> source;
  std::optional<Error> unreached; // why the server is away: the source has what was seen before
};

// cache: where blobs are kept (CachedSource), and found if the server cannot be reached; null: no
// cache. Else as ServerClient::Connect, also in its errors.
Result<ConnectedServer> ConnectServer(const std::string& url, const std::string& token,
  const std::string& authorities, std::shared_ptr<DiskCache> cache, const Execution& execution = {},
  std::optional<std::chrono::seconds> timeout = {});

// All that makes another connection of a VTK class that has a server's model.
struct ServerAddress
{
  std::string url;
  std::string model; // empty: the only model
  std::string token, authorities;
  std::filesystem::path cache;        // a folder (DiskCache); empty: none
  std::uint64_t cacheBytes = 0;       // the cache's maximum size
  std::chrono::seconds timeout{ 60 }; // of silence, after which the server counts as lost

  bool operator==(const ServerAddress&) const = default;
};

// The server at an address, or what its cache has of it. Errors: also those of DiskCache::Open.
Result<std::unique_ptr<ModelSource>> ConnectServer(
  const ServerAddress& address, const Execution& execution = {});

// The error of a server that has sent nothing for this time.
Error NothingArrived(std::chrono::seconds timeout);

// The name of the wanted model, or of the only one. Errors: NotFound, naming the existing ones.
Result<std::string> FindModel(const std::vector<ModelSummary>& models, const std::string& wanted);

// A line each of all but the url, as PrintSelf has them. Of the token, whether there is one.
std::vector<std::string> LinesOf(const ServerAddress& address);

}
