// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/Descriptors.h"

#include <dirent.h>
#include <sys/resource.h>

#include <algorithm>
#include <string>

namespace kdstream
{

namespace
{

// That are open now.
std::uint64_t OpenDescriptors()
{
  std::uint64_t count = 0;
  if (DIR* const folder = ::opendir("/proc/self/fd"))
  {
    while (::readdir(folder))
    {
      ++count;
    }
    ::closedir(folder);
    count -= 3; // ".", ".." and the folder itself
  }
  return count;
}

// What the program opens while it serves, besides connections and stores.
std::uint64_t DescriptorsOfItself(const HttpServerOptions& server)
{
  constexpr std::uint64_t ofLoop = 3;      // Asio's epoll, timer and event
  constexpr std::uint64_t ofListeners = 4; // each has a spare one
  constexpr std::uint64_t ofWatches = 3;   // signals, the folder, the keys
  constexpr std::uint64_t ofReload = 4;    // the folder, a store, a certificate, a log
  return ofLoop * server.threads + ofListeners + ofWatches + ofReload + server.readers;
}

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

// Where there is little, half of what is left is for clients, an eighth each for those who are told
// that there is no place and for the administrator, and the rest for stores that come.
Result<bool> FitConnections(std::uint64_t limit, HttpServerOptions& server)
{
  constexpr std::uint64_t leastLeft = 10;
  constexpr std::uint64_t mostForOthers = 448;
  const auto own = OpenDescriptors() + DescriptorsOfItself(server);
  if (limit < own + leastLeft)
  {
    return Error{ ErrorCode::LimitExceeded, "this process may have " + std::to_string(limit) +
                                              " descriptors (ulimit -n, LimitNOFILE=), " +
                                              "but needs " + std::to_string(own + leastLeft) +
                                              " with these stores, threads and readers" };
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
