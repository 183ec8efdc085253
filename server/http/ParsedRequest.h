// SPDX-License-Identifier: BSD-3-Clause
// Converts a client's request, parsed by Beast, into a request as the routes see it. Internal to
// the server.
#pragma once

#include "server/http/HttpMessage.h"
#include "server/http/RequestForm.h"

#include <boost/beast/core/string.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>

#include <cstddef>
#include <cstdint>
#include <string>

namespace kdstream
{

using RequestParser = boost::beast::http::request_parser<boost::beast::http::empty_body>;
using ParsedRequest = RequestParser::value_type;

// Sets the parser's limits: the header (the request line and the fields) has at most `headerBytes`
// bytes, and there is no body.
inline void SetLimits(RequestParser& parser, std::size_t headerBytes)
{
  parser.header_limit(static_cast<std::uint32_t>(headerBytes));
  parser.body_limit(0);
  parser.eager(true);
}

// Whether the request announces a body, even an empty chunked one. Then the bytes after the header
// are not another request.
inline bool AnnouncesBody(const RequestParser& parser)
{
  return parser.is_header_done() &&
         (!parser.is_done() ||
           parser.get().count(boost::beast::http::field::transfer_encoding) != 0);
}

// The values of all fields with this name, joined by commas.
inline std::string JoinedFields(const ParsedRequest& request, boost::beast::string_view name)
{
  std::string values;
  const auto range = request.equal_range(name);
  for (auto each = range.first; each != range.second; ++each)
  {
    values += values.empty() ? "" : ",";
    values.append(each->value().data(), each->value().size());
  }
  return values;
}

// client: the client's address.
inline HttpRequest PlainRequest(const ParsedRequest& request, const std::string& client)
{
  namespace http = boost::beast::http;
  const auto field = [&](http::field name)
  {
    const auto value = request[name];
    return std::string(value.data(), value.size());
  };
  const auto method = request.method_string();
  const auto target = request.target();
  return { std::string(method.data(), method.size()),
    SplitTarget({ target.data(), target.size() }).path, field(http::field::if_none_match),
    field(http::field::range), field(http::field::if_range),
    JoinedFields(request, "Accept-Encoding"), field(http::field::authorization), client, {} };
}

}
