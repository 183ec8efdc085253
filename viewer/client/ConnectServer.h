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
  std::optional<Error> unreached; // why the server cannot be reached; the source is then the cache
};

// cache: keeps blobs (CachedSource), and answers if the server cannot be reached; null: no cache.
// Otherwise this is as ServerClient::Connect, with the same errors.
Result<ConnectedServer> ConnectServer(const std::string& url, const std::string& token,
  const std::string& authorities, std::shared_ptr<DiskCache> cache, const Execution& execution = {},
  std::optional<std::chrono::seconds> timeout = {});

// The settings of a VTK class that reads a server's model: if one changes, it needs another
// connection.
struct ServerAddress
{
  std::string url;
  std::string model; // empty: the only model
  std::string token, authorities;
  std::filesystem::path cache;        // a folder (DiskCache); empty: none
  std::uint64_t cacheBytes = 0;       // the cache's maximum size
  std::chrono::seconds timeout{ 60 }; // after this time of silence the server counts as lost

  bool operator==(const ServerAddress&) const = default;
};

// The server at an address, or the cache if the server cannot be reached. Errors: as above, and
// those of DiskCache::Open.
Result<std::unique_ptr<ModelSource>> ConnectServer(
  const ServerAddress& address, const Execution& execution = {});

// The error of a server that has sent nothing for this time.
Error NothingArrived(std::chrono::seconds timeout);

// The name of the wanted model, or of the only one. Errors: NotFound, naming the existing ones.
Result<std::string> FindModel(const std::vector<ModelSummary>& models, const std::string& wanted);

// The lines for PrintSelf: one for each member except the url. For the token only whether there is
// one.
std::vector<std::string> LinesOf(const ServerAddress& address);

}
