// SPDX-License-Identifier: BSD-3-Clause
// What goes before an answer's body. Internal to the server.
#pragma once

#include "server/http/HttpMessage.h"

#include <chrono>
#include <string>

namespace kdstream
{

// Status line and fields, with the empty line after them. isOld: for HTTP/1.0. strictTransport: for
// so long browsers use no plain HTTP with this host; 0: they are told nothing.
std::string WriteResponseHead(
  const HttpResponse& response, bool isOld, bool keepAlive, std::chrono::seconds strictTransport);

}
