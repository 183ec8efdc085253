// SPDX-License-Identifier: BSD-3-Clause
// What RFC 9112 says of a request's form and Beast's parser leaves to its caller. Internal to the
// server.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// How many bytes of what has come are an empty line before a request, which servers should ignore
// (section 2.2); nothing while that cannot be told.
std::optional<std::size_t> EmptyLine(std::string_view input);

// Whether a line of the header received so far begins with a blank. It would continue the line
// before (section 5.2), and proxies may read another request there than the server does.
bool HasFoldedLine(std::string_view input);

// The host that the field Host, or a target, names, without its port and its final dot: letters,
// digits and -._~, an address of IPv6 in [brackets], or "". Nothing where it is malformed (RFC
// 9110, 7.2; RFC 3986, 3.2.2, of which percent-encoding and !$&'()*+,;= are left out: no host has
// them).
std::optional<std::string_view> ParseHost(std::string_view field);

// Whether a page of a stranger cannot have this name for its host: DNS rebinding has a browser that
// loaded the page from the stranger's name ask this machine under that name. Such a name is one
// that somebody has registered, so it has a dot. An address is not a name, those of localhost lead
// to the machine itself in every browser, and a name without a dot is nobody's in the public DNS.
// host: as ParseHost gives it. False for "", which names nobody.
bool CannotBeRebound(std::string_view host);

struct RequestTarget
{
  std::optional<std::string> host; // that it names, with its port: instead of the field Host
  std::string path;                // with the query
};

// "http://HOST/PATH" as well as "/PATH" (section 3.2). What is neither is left as it is.
RequestTarget SplitTarget(std::string_view target);

}
