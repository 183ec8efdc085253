// SPDX-License-Identifier: BSD-3-Clause
// The file descriptors that kdstream-serve may have, and how many clients they are enough for.
#pragma once

#include "filters/core/Result.h"
#include "server/http/HttpServer.h"

#include <cstdint>
#include <optional>

namespace kdstream
{

// Raises the limit of descriptors as far as the system allows. Returns the limit, or nothing if
// there is none.
std::optional<std::uint64_t> TakeDescriptors();

// The number of stores that may stay open at a time, at most `wanted`. It is one, plus a quarter of
// the descriptors that `limit` leaves for stores and clients. Call this before anything is opened.
// Errors: LimitExceeded if `limit` is not enough for the program with one store; the message says
// what number would be enough.
Result<std::size_t> FitOpenStores(
  std::uint64_t limit, std::size_t wanted, const HttpServerOptions& server);

// Reduces the server's connections to what `limit` descriptors allow. Counted first is what the
// program has open, and what it will open: event loops, listeners, watches, a file for each reader,
// further stores. Call this when stores, logs and quotas are open. Returns whether connections were
// reduced. Errors: LimitExceeded if the limit does not allow even a few connections.
Result<bool> FitConnections(std::uint64_t limit, HttpServerOptions& server);

}
