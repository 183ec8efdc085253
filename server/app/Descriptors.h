// SPDX-License-Identifier: BSD-3-Clause
// The file descriptors that kdstream-serve may have, and for how many clients they are enough.
#pragma once

#include "filters/core/Result.h"
#include "server/http/HttpServer.h"

#include <cstdint>
#include <optional>

namespace kdstream
{

// Raises the limit as far as the system allows; returns it, or nothing if there is no limit.
std::optional<std::uint64_t> TakeDescriptors();

// The number of stores that may stay open at a time, at most `wanted`: a quarter of the descriptors
// that `limit` leaves, and one. Call this before anything is opened. Errors: LimitExceeded if
// `limit` is not enough for the program with one store; the message has the number that is.
Result<std::size_t> FitOpenStores(
  std::uint64_t limit, std::size_t wanted, const HttpServerOptions& server);

// Reduces the server's connections to what `limit` descriptors allow, beside what the program has
// open and will open: event loops, listeners, watches, a file for each reader, further stores. Call
// this when stores, logs and quotas are open. Returns whether connections were reduced. Errors:
// LimitExceeded if not even a few are possible.
Result<bool> FitConnections(std::uint64_t limit, HttpServerOptions& server);

}
