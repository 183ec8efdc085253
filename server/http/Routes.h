// SPDX-License-Identifier: BSD-3-Clause
// Which answer a request gets: the GET routes of doc/protocol.md. Step "serve" of the README's
// picture. No sockets: a pure function of the request, the catalog and the web folder.
#pragma once

#include "server/http/HttpMessage.h"
#include "server/http/Metrics.h"
#include "server/http/StaticFiles.h"
#include "server/session/Catalog.h"

#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

struct RouteOptions
{
  std::string allowOrigin;        // Access-Control-Allow-Origin; empty: none is sent
  std::optional<StaticFiles> web; // what "/" serves; else a page of text
  std::string version;
};

class Routes
{
public:
  // REQUIRES: catalog and metrics outlive the routes.
  Routes(const Catalog& catalog, Metrics& metrics, RouteOptions options);

  // From any thread. Never fails: errors are responses too.
  HttpResponse Answer(const HttpRequest& request) const;

  // {"error":"…"} with the fields that every answer has.
  HttpResponse Failure(unsigned status, std::string_view message) const;

  // Whether a page from `origin` (the header field; "" = not a browser) may open a stream at
  // `host`: pages of this server may, and those that allowOrigin names. The server has to check,
  // because browsers open WebSockets to any host.
  bool MayStream(std::string_view origin, std::string_view host) const;

private:
  HttpResponse Route(const HttpRequest& request, std::string_view path) const;
  HttpResponse AnswerApi(const HttpRequest& request, std::string_view path) const;
  HttpResponse AnswerModelList(const HttpRequest& request) const;
  HttpResponse AnswerModel(const HttpRequest& request, const ServedModel& model) const;
  HttpResponse AnswerBlob(
    const HttpRequest& request, const ServedModel& model, const protocol::BlobId& id) const;
  HttpResponse AnswerFile(const HttpRequest& request, std::string_view path) const;
  HttpResponse Preflight() const;

  const Catalog& Models;
  Metrics& Counters;
  RouteOptions Options;
};

}
