// SPDX-License-Identifier: BSD-3-Clause
// The checks of a request's form that RFC 9112 demands and Beast's parser leaves to its caller.
// Internal to the server.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// How many of the bytes received are an empty line before a request, which servers should ignore
// (section 2.2); nothing if more bytes are needed to decide.
std::optional<std::size_t> EmptyLine(std::string_view input);

// Whether a line of the header received so far begins with a blank. It would continue the line
// before (section 5.2), and proxies may read another request there than the server does.
bool HasFoldedLine(std::string_view input);

// The host in the field Host, or in a target, without its port and its final dot: letters, digits
// and -._~, an address of IPv6 in [brackets], or "". Nothing if it is malformed (RFC 9110, 7.2; RFC
// 3986, 3.2.2, without percent-encoding and !$&'()*+,;=, which no host has).
std::optional<std::string_view> ParseHost(std::string_view field);

// Whether the host is safe from DNS rebinding. In that attack a browser has loaded a page from a
// registered name, which then resolves to this machine. A registered name has a dot. So these are
// safe: an address; localhost, which browsers always resolve to the machine itself; a name without
// a dot, which nobody owns in the public DNS. host: as ParseHost returns it. False for "".
bool CannotBeRebound(std::string_view host);

struct RequestTarget
{
  std::optional<std::string> host; // the host in the target, with its port; replaces the field Host
  std::string path;                // with the query
};

// "http://HOST/PATH" as well as "/PATH" (section 3.2). What is neither is left as it is.
RequestTarget SplitTarget(std::string_view target);

}
