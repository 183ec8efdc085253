// SPDX-License-Identifier: BSD-3-Clause
// Checks of a request's form that RFC 9112 demands and that Beast's parser leaves to its caller.
// Internal to the server.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// The length of an empty line that precedes a request, which servers should ignore (section 2.2); 0
// if there is none. Nothing if more bytes are needed to decide.
std::optional<std::size_t> EmptyLine(std::string_view input);

// Whether a line of the header received so far begins with a blank. Such a line would continue the
// previous one (section 5.2), and proxies may read a different request there than the server does.
bool HasFoldedLine(std::string_view input);

// The host in the field Host, or in a target, without its port and its final dot. It consists of
// letters, digits and -._~, or is an IPv6 address in [brackets], or "". Nothing if it is malformed
// (RFC 9110, 7.2; RFC 3986, 3.2.2, without percent-encoding and !$&'()*+,;=, which occur in no
// host).
std::optional<std::string_view> ParseHost(std::string_view field);

// Whether the host is safe from DNS rebinding. In that attack a browser has loaded a page from a
// registered name, which then resolves to this machine. A registered name has a dot. So these hosts
// are safe: an address; localhost, which browsers always resolve to the machine itself; a name
// without a dot, which nobody owns in the public DNS. host: as ParseHost returns it. False for "".
bool CannotBeRebound(std::string_view host);

struct RequestTarget
{
  std::optional<std::string> host; // the host in the target, with its port; replaces the field Host
  std::string path;                // with the query
};

// Splits "http://HOST/PATH" or "/PATH" (section 3.2). Any other target is left as it is.
RequestTarget SplitTarget(std::string_view target);

}
