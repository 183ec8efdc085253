// SPDX-License-Identifier: BSD-3-Clause
// The address of a server as a person writes it.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <string_view>

namespace kdstream
{

struct ServerUrl
{
  std::string host; // name or address, an IPv6 address without its brackets
  std::string port = "80";

  // "HOST:PORT" as in a Host header.
  std::string Authority() const;
};

// Parses http://HOST[:PORT][/].
// Errors: Unsupported for https, whose certificates this client cannot check yet; InvalidArgument
// for anything else, naming what is wrong with it.
Result<ServerUrl> ParseServerUrl(std::string_view url);

}
