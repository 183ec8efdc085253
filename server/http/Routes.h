// SPDX-License-Identifier: BSD-3-Clause
// Which answer a request gets: the GET routes of doc/protocol.md. Step "serve" of the pipeline
// picture. No sockets: an answer depends only on the request, the catalog and the web folder.
#pragma once

#include "filters/protocol/ResourcePath.h"
#include "server/http/HttpMessage.h"
#include "server/http/Metrics.h"
#include "server/http/StaticFiles.h"
#include "server/pages/ModelPages.h"
#include "server/session/Catalog.h"
#include "server/session/Permission.h"
#include "server/tiles/TileKeeper.h"

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kdstream
{

struct RouteOptions
{
  std::string allowOrigin;        // Access-Control-Allow-Origin; empty: not sent
  std::optional<StaticFiles> web; // the files below "/"; without them, a page of text
  std::string version;
  bool metrics = true; // whether "/metrics" is answered here, or only by AnswerAdmin
  std::function<bool()> isDraining = {}; // whether the server is stopping; empty: it never is
  // Checks the tokens for models; null: no tokens are needed.
  std::shared_ptr<const TokenGuard> guard = {};
  // Records the partitions that clients get; null: nothing is recorded.
  std::shared_ptr<const PartitionLedger> ledger = {};
  // The number of lines that the server's logs have lost; empty: there are no logs.
  std::function<std::uint64_t()> lostLines = {};
  std::string contact = {}; // sent to clients without a valid token, unless empty
};

class Routes
{
public:
  // REQUIRES: catalog and metrics outlive the routes.
  Routes(const Catalog& catalog, Metrics& metrics, RouteOptions options);

  enum class Counts
  {
    No,
    Perhaps, // decided by Reading::Uncounted
    Yes
  };
  // Makes an answer that is not given at once. All objects that the request names have been found,
  // and the client's permission has been checked. The functions may wait for a disk; an error also
  // becomes an answer. REQUIRES: the routes outlive this object.
  class Reading
  {
  public:
    Counts counts = Counts::No;   // against a quota
    const void* source = nullptr; // the model or folder that is read, by its address
    std::string part = {};        // the part of the model, if several readers may share the read
    bool isMade = false;          // takes much computing: reads of blobs do not wait for it

    HttpResponse Answer() const { return *this->Read(true); }
    // The answer if it counts against no quota; else nothing.
    std::optional<HttpResponse> Uncounted() const { return this->Read(false); }

  private:
    friend class Routes;
    std::function<std::optional<HttpResponse>(bool mayCount)> Read;
  };
  // The answer, if it needs no waiting; else the Reading that makes the answer. From any thread.
  std::variant<HttpResponse, Reading> Find(const HttpRequest& request) const;

  // Answers the administrator: /metrics, /healthz, /readyz. Never waits.
  HttpResponse AnswerAdmin(const HttpRequest& request) const;

  // Whether the target asks how the server is: /healthz or /readyz.
  static bool IsProbe(std::string_view target);

  // The permission of a client with this address, if its request has these fields. Errors:
  // InvalidInput, with a message for the client, if it needs a valid token and has none: 401.
  Result<Permission> Admit(const std::string& client, std::string_view authorization,
    std::string_view subprotocols = {}) const;
  // Counts the refusal, and returns the answer for it: the client may not have what it asks for.
  HttpResponse Forbidden(const Refusal& refusal) const;

  // The answer {"error":"…"}, with "contact" unless it is empty, and with the fields that every
  // answer has.
  HttpResponse Failure(unsigned status, std::string_view message,
    std::chrono::seconds retryAfter = std::chrono::seconds(0), std::string_view contact = {}) const;

  // Whether a page from `origin` (the header field; "" = not a browser) may open a stream at
  // `host`. Pages of this server may, and pages of the origins that allowOrigin names. The server
  // must check this, because browsers open WebSockets to any host.
  bool MayStream(std::string_view origin, std::string_view host) const;

private:
  using Found = std::variant<HttpResponse, Reading>;
  struct AskedBlob;
  struct AskedTile;
  Found Route(const HttpRequest& request, std::string_view path) const;
  Found FindApi(const HttpRequest& request, std::string_view path) const;
  std::optional<HttpResponse> RefuseMisuse(const HttpRequest& request) const;
  HttpResponse Finished(const HttpRequest& request, HttpResponse response) const;
  std::optional<HttpResponse> AnswerOwn(std::string_view path, bool metrics) const;
  HttpResponse AnswerReady() const;
  Found FindOfModels(const HttpRequest& request, const protocol::ResourcePath& resource) const;
  HttpResponse AnswerModelList(const HttpRequest& request, const Permission& permission) const;
  Found FindModel(
    const HttpRequest& request, std::shared_ptr<const ServedModel> model, ModelDetail detail) const;
  HttpResponse AnswerNotes(const HttpRequest& request, const std::string& model) const;
  Found FindBlob(const HttpRequest& request, AskedBlob asked) const;
  std::optional<HttpResponse> ReadBlob(
    const HttpRequest& request, const AskedBlob& asked, bool mayCount) const;
  HttpResponse AnswerWhole(const HttpRequest& request, const AskedBlob& asked,
    const BlobBytes& bytes, std::size_t length) const;
  Found FindTile(const HttpRequest& request, const protocol::ResourcePath& resource,
    std::shared_ptr<const ServedModel> model, Permission permission) const;
  std::optional<HttpResponse> ReadTile(
    const HttpRequest& request, const AskedTile& asked, bool mayCount) const;
  HttpResponse AnswerTile(
    const HttpRequest& request, const AskedTile& asked, const BlobBytes& bytes) const;
  Found FindFile(const HttpRequest& request, std::string_view path) const;
  HttpResponse ReadFile(const HttpRequest& request, const std::string& path, bool gzip) const;
  HttpResponse AnswerFile(const HttpRequest& request, const StaticFile& file) const;
  Found FindPage(const HttpRequest& request, PagePath asked) const;
  HttpResponse AnswerPage(const HttpRequest& request, const PagePath& asked,
    const ServedModel* model, const std::vector<ModelSummary>& listed,
    const std::string& lacking) const;
  // Summaries of the first models that the permission allows, at most `most` of them.
  std::vector<ModelSummary> SummariesFor(const Permission& permission, std::size_t most) const;
  Found FindForRobots(const HttpRequest& request, std::string_view path) const;
  HttpResponse AnswerDrawn(const HttpRequest& request, const ServedModel& model,
    const std::string& name, const std::string& type, Result<BlobBytes> bytes) const;
  HttpResponse AnswerText(
    const HttpRequest& request, const std::string& type, const std::string& text) const;
  HttpResponse Preflight() const;
  template <class Change>
  static Found Changed(Found found, Change change);

  const Catalog& Models;
  Metrics& Counters;
  RouteOptions Options;
  PictureKeeper Pictures;
  TileKeeper Tiles;
};

}
