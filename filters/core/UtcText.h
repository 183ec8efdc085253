// SPDX-License-Identifier: BSD-3-Clause
// Times as readable text, for logs, tokens and quotas. A header of its own, because the C library's
// calendar functions need environment variables, which the web page does not have.
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

namespace kdstream
{

// Seconds since 1970 as "2026-11-27T01:02:03Z" (RFC 3339); empty for years that the C library
// cannot represent.
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
