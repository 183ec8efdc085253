// SPDX-License-Identifier: BSD-3-Clause
// A server as a session's source, with what is kept on the disk of it. Step "receive" of the
// README's picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "viewer/client/DiskCache.h"
#include "viewer/client/ModelSource.h"

#include <memory>
#include <optional>
#include <string>

namespace kdstream
{

struct ConnectedServer
{
  std::unique_ptr<ModelSource> source;
  std::optional<Error> unreached; // why the server is away: the source has what was seen before
};

// cache: where what comes is kept (CachedSource), and found where the server cannot be reached;
// null: nowhere. Else as ServerClient::Connect, also in its errors.
Result<ConnectedServer> ConnectServer(const std::string& url, const std::string& token,
  const std::string& authorities, std::shared_ptr<DiskCache> cache,
  const Execution& execution = {});

}
