// SPDX-License-Identifier: BSD-3-Clause
// The complete answer to a request, read if necessary: does in one call what a connection and its
// reader do.
#pragma once

#include "server/http/Routes.h"

#include <utility>
#include <variant>

namespace kdstream
{

inline HttpResponse Answer(const Routes& routes, const HttpRequest& request)
{
  auto found = routes.Find(request);
  auto* const response = std::get_if<HttpResponse>(&found);
  return response ? std::move(*response) : std::get<Routes::Reading>(found).Answer();
}

}
