// SPDX-License-Identifier: BSD-3-Clause
// A GET request to a server, and its answer, independent of the code that sends it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string>

namespace kdstream
{

struct HttpFetch
{
  std::string target;        // a path
  std::size_t mostBytes = 0; // of the answer's body
};

struct HttpReply
{
  unsigned status = 0;
  std::string body;
  double retryAfter = 0; // s; the pause that the server asks for with 429 and 503; 0: none
};

// Whether to ask again: 429 and 503, and 502 and 504 from a proxy that cannot reach its server, say
// nothing about what was requested.
constexpr bool IsBusy(unsigned status)
{
  return status == 429 || (status >= 502 && status <= 504);
}

// The seconds that a Retry-After field asks for: at most an hour; a date counts as none.
inline double RetryAfterIn(const std::string& field)
{
  return static_cast<double>(std::min(std::strtoul(field.c_str(), nullptr, 10), 3600ul));
}

// 401 and 403 are about the client: it may fetch nothing of the model.
constexpr bool IsForbidden(unsigned status)
{
  return status == 401 || status == 403;
}

}
