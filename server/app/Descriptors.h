// SPDX-License-Identifier: BSD-3-Clause
// The file descriptors that kdstream-serve may have, and for how many clients they are enough.
#pragma once

#include "filters/core/Result.h"
#include "server/http/HttpServer.h"

#include <cstdint>
#include <optional>

namespace kdstream
{

// Takes as many as the system gives; their number, or nothing where there is no limit.
std::optional<std::uint64_t> TakeDescriptors();

// How many stores may stay open at a time, at most `wanted`: a quarter of what `limit` leaves, and
// one. To be called before anything is opened. Errors: LimitExceeded where it is not enough for the
// program with one store: the message has the number that is.
Result<std::size_t> FitOpenStores(
  std::uint64_t limit, std::size_t wanted, const HttpServerOptions& server);

// Sets server's connections to what `limit` descriptors are enough for, after what the program has
// open and what it will open: event loops, listeners, watches, a file for each reader, stores that
// come. To be called once stores, logs and quotas are open. Whether they became fewer. Errors:
// LimitExceeded where not even a few are left.
Result<bool> FitConnections(std::uint64_t limit, HttpServerOptions& server);

}
