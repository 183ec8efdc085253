// SPDX-License-Identifier: BSD-3-Clause
// A server as a session's source, with what is kept on the disk of it.
#include "viewer/client/ConnectServer.h"

#include "viewer/client/CachedSource.h"
#include "viewer/client/ServerClient.h"
#include "viewer/client/ServerUrl.h"

#include <utility>

namespace kdstream
{

Result<ConnectedServer> ConnectServer(const std::string& url, const std::string& token,
  const std::string& authorities, std::shared_ptr<DiskCache> cache, const Execution& execution)
{
  const auto server = ParseServerUrl(url);
  KDSTREAM_TRY(server);
  auto client = ServerClient::Connect(url, token, authorities, execution);
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

}
