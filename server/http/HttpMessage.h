// SPDX-License-Identifier: BSD-3-Clause
// A request and its answer as the routes see them, and the text that precedes the answer's body. No
// sockets.
#pragma once

#include "server/session/Catalog.h"

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

struct HttpRequest
{
  std::string method;                      // "GET"
  std::string target;                      // "/api/models.json?x=1"
  std::string ifNoneMatch, range, ifRange; // header fields; empty where absent
  std::string acceptEncoding = {};         // several fields joined by commas
  std::string authorization = {};
  std::string client = {}; // the client's address
  // The address under which the server is reached, with a slash at its end. Empty if it is unknown,
  // or if the client might have invented it.
  std::string root = {};
};

struct HttpResponse
{
  unsigned status = 200;
  std::vector<std::pair<std::string, std::string>> fields; // without Content-Length
  BlobBytes body;                                          // null: no body
  std::size_t begin = 0;                                   // the part of `body` that is sent
  std::size_t length = 0;
  bool omitBody = false; // HEAD: Content-Length is `length`, but nothing follows

  // The value of the field with this name, or "".
  std::string_view Field(std::string_view name) const;
};

// The status line and the fields, with the empty line after them. isOld: the answer is for
// HTTP/1.0. strictTransport: the time for which browsers are to use only HTTPS with this host
// (HSTS); 0: the field is left out.
std::string WriteResponseHead(
  const HttpResponse& response, bool isOld, bool keepAlive, std::chrono::seconds strictTransport);

}
