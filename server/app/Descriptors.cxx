// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/Descriptors.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/resource.h>

#include <algorithm>
#include <string>

namespace kdstream
{

namespace
{

// The number of open descriptors. If no descriptor is left for listing them, each possible number
// is tried.
std::uint64_t OpenDescriptors(std::uint64_t limit)
{
  std::uint64_t count = 0;
  if (DIR* const folder = ::opendir("/proc/self/fd"))
  {
    while (::readdir(folder))
    {
      ++count;
    }
    ::closedir(folder);
    return count - 3; // ".", ".." and the folder itself
  }
  constexpr std::uint64_t most = 1 << 20;
  for (int file = 0; file < static_cast<int>(std::min(limit, most)); ++file)
  {
    count += ::fcntl(file, F_GETFD) >= 0 ? 1 : 0;
  }
  return count;
}

constexpr std::uint64_t leastLeft = 10; // for clients, the administrator and later stores

Error TooFew(std::uint64_t limit, std::uint64_t least)
{
  return { ErrorCode::LimitExceeded,
    "this process may open " + std::to_string(limit) + " descriptors, but needs at least " +
      std::to_string(least) +
      " for its threads and readers: raise the limit (ulimit -n, LimitNOFILE=)" };
}

// How many descriptors the program opens while it serves, besides connections and stores.
std::uint64_t DescriptorsOfItself(const HttpServerOptions& server)
{
  constexpr std::uint64_t ofLoop = 3;      // Asio's epoll, timer and event
  constexpr std::uint64_t ofListeners = 4; // each has a spare descriptor
  constexpr std::uint64_t ofWatches = 3;   // signals, the folder, the keys
  constexpr std::uint64_t ofReload = 4;    // the folder, a store, a certificate, a log
  return ofLoop * server.threads + ofListeners + ofWatches + ofReload + server.readers +
         server.Makers();
}

}

Result<std::size_t> FitOpenStores(
  std::uint64_t limit, std::size_t wanted, const HttpServerOptions& server)
{
  constexpr std::uint64_t ofFiles = 6; // logs, quotas, keys, certificates: not open yet
  const auto least = OpenDescriptors(limit) + DescriptorsOfItself(server) + ofFiles + 1 + leastLeft;
  if (limit < least)
  {
    return TooFew(limit, least);
  }
  const auto stores = 1 + (limit - least) / 4;
  return static_cast<std::size_t>(std::min<std::uint64_t>(stores, wanted));
}

std::optional<std::uint64_t> TakeDescriptors()
{
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0)
  {
    return std::nullopt;
  }
  limit.rlim_cur = limit.rlim_max;
  (void)::setrlimit(RLIMIT_NOFILE, &limit);
  (void)::getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? std::nullopt : std::optional(limit.rlim_cur);
}

// If descriptors are short, half of the rest is for clients, an eighth for clients that are refused
// for lack of a slot, an eighth for the administrator, and the rest for further stores.
Result<bool> FitConnections(std::uint64_t limit, HttpServerOptions& server)
{
  constexpr std::uint64_t mostForOthers = 448;
  const auto own = OpenDescriptors(limit) + DescriptorsOfItself(server);
  if (limit < own + leastLeft)
  {
    return TooFew(limit, own + leastLeft);
  }
  const auto left = limit - own;
  const auto clients = left - std::min(mostForOthers, left / 2);
  const bool isShort = server.maximumConnections > clients;
  server.maximumConnections =
    std::min(server.maximumConnections, static_cast<std::size_t>(clients));
  server.extraConnections = std::min(
    server.extraConnections, static_cast<std::size_t>(std::max<std::uint64_t>(2, left / 8)));
  return isShort;
}

}
