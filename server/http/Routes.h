// SPDX-License-Identifier: BSD-3-Clause
// Which answer a request gets: the GET routes of doc/protocol.md. Step "serve" of the README's
// picture. No sockets: a function of the request, the catalog and the web folder.
#pragma once

#include "filters/protocol/ResourcePath.h"
#include "server/http/HttpMessage.h"
#include "server/http/Metrics.h"
#include "server/http/StaticFiles.h"
#include "server/session/Catalog.h"
#include "server/session/Permission.h"

#include <chrono>
#include <functional>
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
  bool metrics = true; // whether "/metrics" is answered here, or by AnswerAdmin alone
  std::function<bool()> isDraining = {};        // whether the server is stopping; none: it is not
  std::shared_ptr<const TokenGuard> guard = {}; // whose tokens models take; null: they take none
  std::shared_ptr<const PartitionLedger> ledger = {}; // where partitions are entered; null: nowhere
  std::function<std::uint64_t()> lostLines = {};      // of the server's logs; none: there are none
};

class Routes
{
public:
  // REQUIRES: catalog and metrics outlive the routes.
  Routes(const Catalog& catalog, Metrics& metrics, RouteOptions options);

  // From any thread. Errors are responses too. May wait for a disk.
  HttpResponse Answer(const HttpRequest& request) const;
  // The same where it waits for nobody, else nothing.
  std::optional<HttpResponse> AnswerAtOnce(const HttpRequest& request) const;
  // The same where it counts against no quota, else nothing. May wait for a disk.
  std::optional<HttpResponse> AnswerUncounted(const HttpRequest& request) const;

  enum class Counts
  {
    No,
    Perhaps, // AnswerUncounted finds it out
    Yes
  };
  // What an answer that is not given at once waits for.
  struct Needs
  {
    Counts counts = Counts::No;   // against a quota
    const void* source = nullptr; // the model or the folder of files that is read, by address
    std::string part = {};        // of it, where others may read the same
  };
  Needs NeedsOf(const HttpRequest& request) const;

  // What the administrator may ask: /metrics, /healthz, /readyz. Waits for nobody.
  HttpResponse AnswerAdmin(const HttpRequest& request) const;

  // Whether the target asks how the server is: /healthz or /readyz.
  static bool IsProbe(std::string_view target);

  // What a client (its address) may have with these fields of its request. Errors: InvalidInput, in
  // words, where it needs a token and has no valid one: 401.
  Result<Permission> Admit(const std::string& client, std::string_view authorization,
    std::string_view subprotocols = {}) const;
  // The answer to a client that may not have what it asks for, which is counted.
  HttpResponse Forbidden(const Refusal& refusal) const;

  // {"error":"…"} with the fields that every answer has.
  HttpResponse Failure(unsigned status, std::string_view message,
    std::chrono::seconds retryAfter = std::chrono::seconds(0)) const;

  // Whether a page from `origin` (the header field; "" = not a browser) may open a stream at
  // `host`: pages of this server may, and those that allowOrigin names. The server has to check,
  // because browsers open WebSockets to any host.
  bool MayStream(std::string_view origin, std::string_view host) const;

private:
  enum class Patience
  {
    None,
    Disk, // waits for one
    Quota // and for the quotas' file
  };
  using Answered = std::optional<HttpResponse>; // nothing for want of patience
  Answered Answer(const HttpRequest& request, Patience patience) const;
  Answered Route(const HttpRequest& request, std::string_view path, Patience patience) const;
  Answered AnswerApi(const HttpRequest& request, std::string_view path, Patience patience) const;
  Answered RefuseMisuse(const HttpRequest& request) const;
  HttpResponse Finished(const HttpRequest& request, HttpResponse response) const;
  Answered AnswerOwn(std::string_view path, bool metrics) const;
  HttpResponse AnswerReady() const;
  Answered AnswerModels(
    const HttpRequest& request, const protocol::ResourcePath& resource, Patience patience) const;
  HttpResponse AnswerModelList(const HttpRequest& request, const Permission& permission) const;
  Answered AnswerModel(const HttpRequest& request, const ServedModel& model, ModelDetail detail,
    Patience patience) const;
  Answered AnswerNotes(
    const HttpRequest& request, const std::string& model, Patience patience) const;
  Answered AnswerBlob(const HttpRequest& request, const ServedModel& model,
    const protocol::BlobId& id, const Permission& permission, Patience patience) const;
  Answered AnswerFile(const HttpRequest& request, std::string_view path, Patience patience) const;
  HttpResponse AnswerFile(const HttpRequest& request, const StaticFile& file) const;
  HttpResponse Preflight() const;

  const Catalog& Models;
  Metrics& Counters;
  RouteOptions Options;
};

}
