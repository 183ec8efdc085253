// SPDX-License-Identifier: BSD-3-Clause
// A server as a session's source, with a cache on the disk: see ConnectServer.h.
#include "viewer/client/ConnectServer.h"

#include "viewer/client/CachedSource.h"
#include "viewer/client/ServerClient.h"
#include "viewer/client/ServerUrl.h"

#include <utility>

namespace kdstream
{

Result<ConnectedServer> ConnectServer(const std::string& url, const std::string& token,
  const std::string& authorities, std::shared_ptr<DiskCache> cache, const Execution& execution,
  std::optional<std::chrono::seconds> timeout)
{
  const auto server = ParseServerUrl(url);
  KDSTREAM_TRY(server);
  auto client = ServerClient::Connect(url, token, authorities, execution, timeout);
  if (client && cache)
  {
    return ConnectedServer{
      std::make_unique<CachedSource>(std::move(*client), std::move(cache), server->Origin()), {}
    };
  }
  if (client)
  {
    return ConnectedServer{ std::move(*client), {} };
  }
  if (!cache || client.GetError().code != ErrorCode::InputOutput)
  {
    return client.GetError();
  }
  auto offline = CachedSource::Offline(std::move(cache), server->Origin());
  if (!offline)
  {
    return client.GetError();
  }
  return ConnectedServer{ std::move(*offline), client.GetError() };
}

Result<std::unique_ptr<ModelSource>> ConnectServer(
  const ServerAddress& address, const Execution& execution)
{
  std::shared_ptr<DiskCache> cache;
  if (!address.cache.empty())
  {
    auto opened = DiskCache::Open(address.cache, address.cacheBytes);
    KDSTREAM_TRY(opened);
    cache = std::move(*opened);
  }
  auto connected = ConnectServer(
    address.url, address.token, address.authorities, std::move(cache), execution, address.timeout);
  KDSTREAM_TRY(connected);
  return std::move(connected->source);
}

Error NothingArrived(std::chrono::seconds timeout)
{
  return { ErrorCode::InputOutput,
    "the server has sent nothing for " + std::to_string(timeout.count()) + " s" };
}

Result<std::string> FindModel(const std::vector<ModelSummary>& models, const std::string& wanted)
{
  std::string names;
  for (const ModelSummary& model : models)
  {
    if (model.id == wanted || (wanted.empty() && models.size() == 1))
    {
      return model.id;
    }
    names += (names.empty() ? "" : ", ") + model.id;
  }
  return Error{ ErrorCode::NotFound, models.empty() ? "there are no models"
                                     : wanted.empty()
                                       ? "there are several models; name one of " + names
                                       : "there is no model " + wanted + "; there are " + names };
}

std::vector<std::string> LinesOf(const ServerAddress& address)
{
  return { "ModelId: " + address.model, address.token.empty() ? "Token: (none)" : "Token: (set)",
    "CertificateAuthorities: " + address.authorities, "CacheFolder: " + address.cache.string(),
    "CacheSize: " + std::to_string(address.cacheBytes),
    "Timeout: " + std::to_string(address.timeout.count()) };
}

}
