// SPDX-License-Identifier: BSD-3-Clause
// Decides which of a server's error messages are logged, because a failing system fails thousands
// of times in the same way. Internal to the server.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// The functions must be called from one thread at a time.
class RareMessages
{
public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds pause{ 60 };

  // The line to log now, if any. A message is logged if it was not logged in the last minute,
  // together with how often it has come since. If there is no memory to remember the message, it is
  // logged.
  std::optional<std::string> Take(std::string_view message, Clock::time_point now = Clock::now());

private:
  struct Reported
  {
    Clock::time_point at;
    std::uint64_t unreported = 0;
  };
  static constexpr std::size_t mostKinds = 100; // with more kinds, all are forgotten

  std::map<std::string, Reported, std::less<>> Kinds;
};

}
