// SPDX-License-Identifier: BSD-3-Clause
// The address of a server as a user writes it, and the token for the server.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <string_view>

namespace kdstream
{

struct ServerUrl
{
  std::string host; // name or address; an IPv6 address without brackets
  std::string port = "80";
  bool isSecure = false;  // https
  std::string token = {}; // for this server (IsToken); empty: none

  // "HOST:PORT" as in a Host header.
  std::string Authority() const;
  // "https://HOST:PORT".
  std::string Origin() const;
};

// Whether a text can be sent as a token: at most 4096 of the characters A-Z a-z 0-9 . _ -.
bool IsToken(std::string_view text);

// Parses http://HOST[:PORT][/] and https://HOST[:PORT][/]. Errors: InvalidArgument, naming what is
// wrong.
Result<ServerUrl> ParseServerUrl(std::string_view url);

}
