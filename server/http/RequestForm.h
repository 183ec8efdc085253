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

// Whether a line of the header, as far as it has come, begins with a blank: it would go on with the
// line before (section 5.2), where proxies may read another request than the server does.
bool HasFoldedLine(std::string_view input);

struct RequestTarget
{
  std::optional<std::string> host; // that it names, with its port: instead of the field Host
  std::string path;                // with the query
};

// "http://HOST/PATH" as well as "/PATH" (section 3.2). What is neither is left as it is.
RequestTarget SplitTarget(std::string_view target);

}
