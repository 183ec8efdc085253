// SPDX-License-Identifier: BSD-3-Clause
// Times as people read them, of the logs, tokens and quotas. A header of its own: the C library's
// calendar asks for the environment, which the page does not give.
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

namespace kdstream
{

// Seconds since 1970 as "2026-11-27T01:02:03Z" (RFC 3339); of years that the C library knows, else
// empty.
inline std::string UtcText(std::int64_t seconds)
{
  const std::time_t time = seconds;
  std::tm utc{};
  char text[40];
  return gmtime_r(&time, &utc) == nullptr
           ? std::string()
           : std::string(text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc));
}

}
