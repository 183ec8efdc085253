// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Routes.h"

#include "filters/model/ModelJson.h"
#include "filters/page/EmbedAnswer.h"
#include "filters/page/GzipText.h"
#include "filters/page/ModelPage.h"
#include "filters/page/PageTexts.h"
#include "filters/protocol/ResourcePath.h"
#include "server/http/ConditionalRequest.h"
#include "server/session/Refusal.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace kdstream
{

namespace
{

constexpr const char* revalidate = "no-cache";
constexpr const char* revalidatePrivate = "private, no-cache";
constexpr const char* immutable = "public, max-age=31536000, immutable";
constexpr const char* immutablePrivate = "private, max-age=31536000, immutable";
// Must be increased when tiles of the same model get different bytes.
constexpr std::uint64_t tilesFormat = 2;

// A hash of the content: 32 hexadecimal digits.
std::string HashOf(const std::vector<std::uint8_t>& bytes, std::uint64_t seed = 0)
{
  const XXH128_hash_t hash = XXH3_128bits_withSeed(bytes.data(), bytes.size(), seed);
  char text[40];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
    static_cast<unsigned long long>(hash.low64));
  return text;
}

// A strong ETag: a hash of the content.
std::string TagOf(const std::vector<std::uint8_t>& bytes)
{
  return "\"" + HashOf(bytes) + "\"";
}

HttpResponse Whole(unsigned status, std::string_view contentType, BlobBytes body)
{
  HttpResponse response;
  response.status = status;
  response.fields.emplace_back("Content-Type", contentType);
  response.length = body->size();
  response.body = std::move(body);
  return response;
}

// An answer that nobody may keep.
HttpResponse NoStore(unsigned status, std::string_view contentType, std::string_view text)
{
  auto response = Whole(status, contentType, BytesOfText(text));
  response.fields.emplace_back("Cache-Control", "no-store");
  return response;
}

// The ETag of a blob. The digest covers the model's content, so digest and name identify the bytes.
std::string TagOfBlob(std::string_view digest, const std::string& name)
{
  return "\"" + std::string(digest) + "/" + name + "\"";
}

std::string AnotherTileset(const std::string& model)
{
  return model + " has changed: read its tileset.json again";
}

std::string_view PathOf(std::string_view target)
{
  return target.substr(0, target.find('?'));
}

std::string_view QueryOf(std::string_view target)
{
  const auto path = PathOf(target);
  return path.size() == target.size() ? std::string_view() : target.substr(path.size() + 1);
}

void DropBody(HttpResponse& response)
{
  response.body.reset();
  response.begin = 0;
  response.length = 0;
}

// Answers 200, or 304 if the client already has these bytes.
HttpResponse Cacheable(const HttpRequest& request, std::string_view contentType, BlobBytes body,
  std::string tag, const char* cacheControl)
{
  auto response = Whole(200, contentType, std::move(body));
  if (NamesTag(request.ifNoneMatch, tag))
  {
    response.status = 304;
    response.fields.clear();
    DropBody(response);
  }
  response.fields.emplace_back("ETag", std::move(tag));
  response.fields.emplace_back("Cache-Control", cacheControl);
  return response;
}

// Reduces a 200 to the part that the request's Range asks for.
HttpResponse Ranged(const HttpRequest& request, HttpResponse response)
{
  response.fields.emplace_back("Accept-Ranges", "bytes");
  const bool stale = !request.ifRange.empty() && request.ifRange != response.Field("ETag");
  if (response.status != 200 || request.method != "GET" || stale)
  {
    return response;
  }
  const auto size = std::to_string(response.length);
  const auto range = ParseRange(request.range, response.length);
  if (const auto* part = std::get_if<PartialRange>(&range))
  {
    response.status = 206;
    response.begin = part->begin;
    response.length = part->length;
    response.fields.emplace_back("Content-Range", "bytes " + std::to_string(part->begin) + "-" +
                                                    std::to_string(part->begin + part->length - 1) +
                                                    "/" + size);
  }
  else if (std::holds_alternative<UnsatisfiableRange>(range))
  {
    response.status = 416;
    DropBody(response);
    response.fields = { { "Content-Range", "bytes */" + size } };
  }
  return response;
}

}

Routes::Routes(const Catalog& catalog, Metrics& metrics, RouteOptions options)
  : Models(catalog)
  , Counters(metrics)
  , Options(std::move(options))
{
}

// A blob that a client may have, with everything that the answer depends on.
struct Routes::AskedBlob
{
  std::shared_ptr<const ServedModel> model;
  protocol::BlobId id;
  Permission permission;
  std::string name, tag;
  bool isCounted = false;
  bool isKnown = false; // no body is sent: the client has it already, or sent HEAD
};

// A file of a model's tileset that a client may have.
struct Routes::AskedTile
{
  std::shared_ptr<const ServedModel> model;
  protocol::BlobId piece; // the piece in the tile, or in the root of a tileset
  Permission permission;
  TileKeeper::Wanted wanted;
  std::string name, tag;
  bool isCounted = false;
  bool isKnown = false; // the client already has it
};

// Applies a change to the answer: now, or after reading if the answer must be read first.
template <class Change>
Routes::Found Routes::Changed(Found found, Change change)
{
  if (auto* response = std::get_if<HttpResponse>(&found))
  {
    *response = change(std::move(*response));
    return found;
  }
  auto& reading = std::get<Reading>(found);
  reading.Read = [read = std::move(reading.Read), change = std::move(change)](bool mayCount)
  {
    auto response = read(mayCount);
    return response ? std::optional(change(std::move(*response))) : std::nullopt;
  };
  return found;
}

HttpResponse Routes::AnswerAdmin(const HttpRequest& request) const
{
  if (auto misuse = this->RefuseMisuse(request))
  {
    return this->Finished(request, std::move(*misuse));
  }
  auto answered = this->AnswerOwn(PathOf(request.target), true);
  return this->Finished(
    request, answered ? std::move(*answered) : this->Failure(404, "there is nothing at this path"));
}

Routes::Found Routes::Find(const HttpRequest& request) const
{
  if (request.method == "OPTIONS" && !this->Options.allowOrigin.empty())
  {
    return this->Finished(request, this->Preflight());
  }
  if (auto misuse = this->RefuseMisuse(request))
  {
    return this->Finished(request, std::move(*misuse));
  }
  return Changed(this->Route(request, PathOf(request.target)),
    [this, request](HttpResponse response)
    { return this->Finished(request, std::move(response)); });
}

// Refuses requests that are not a GET or HEAD of a path.
std::optional<HttpResponse> Routes::RefuseMisuse(const HttpRequest& request) const
{
  if (request.method != "GET" && request.method != "HEAD")
  {
    auto response = this->Failure(405, "only GET and HEAD are allowed");
    response.fields.emplace_back("Allow", "GET, HEAD");
    return response;
  }
  if (request.target.empty() || request.target.front() != '/')
  {
    return this->Failure(400, "the request's target is not a path");
  }
  return std::nullopt;
}

// Adds the fields that all answers have.
HttpResponse Routes::Finished(const HttpRequest& request, HttpResponse response) const
{
  response.omitBody = request.method == "HEAD";
  response.fields.emplace_back("X-Content-Type-Options", "nosniff");
  if (PathOf(request.target) == "/embed.js")
  {
    // Any page may load embed.js as a module, which browsers load across origins only with this
    // field.
    response.fields.emplace_back("Access-Control-Allow-Origin", "*");
  }
  else if (!this->Options.allowOrigin.empty())
  {
    response.fields.emplace_back("Access-Control-Allow-Origin", this->Options.allowOrigin);
    response.fields.emplace_back(
      "Access-Control-Expose-Headers", "ETag, Content-Range, Retry-After");
    if (this->Options.allowOrigin != "*")
    {
      response.fields.emplace_back("Vary", "Origin");
    }
  }
  return response;
}

HttpResponse Routes::Failure(unsigned status, std::string_view message,
  std::chrono::seconds retryAfter, std::string_view contact) const
{
  JsonWriter json;
  json.BeginObject().Member("error", message);
  if (!contact.empty())
  {
    json.Member("contact", contact);
  }
  json.EndObject();
  auto response = NoStore(status, "application/json", json.Text() + "\n");
  if (status == 503 || status == 429 || retryAfter.count() > 0)
  {
    const auto seconds = std::max<std::int64_t>(1, retryAfter.count());
    response.fields.emplace_back("Retry-After", std::to_string(seconds));
  }
  return response;
}

Result<Permission> Routes::Admit(
  const std::string& client, std::string_view authorization, std::string_view subprotocols) const
{
  const auto& ledger = this->Options.ledger;
  if (!this->Options.guard)
  {
    return Permission({}, {}, ledger, client);
  }
  auto pass = this->Options.guard->Admit(FindToken(authorization, subprotocols));
  KDSTREAM_TRY(pass);
  return Permission(this->Options.guard, std::move(*pass), ledger, client);
}

HttpResponse Routes::Forbidden(const Refusal& refusal) const
{
  this->Counters.CountRefusal(Metrics::Reason::Token);
  const bool lacksToken = refusal.status == 401;
  auto response = this->Failure(refusal.status, refusal.message, std::chrono::seconds(0),
    lacksToken ? std::string_view(this->Options.contact) : std::string_view());
  if (lacksToken)
  {
    response.fields.emplace_back("WWW-Authenticate", "Bearer");
  }
  return response;
}

bool Routes::IsProbe(std::string_view target)
{
  const auto path = PathOf(target);
  return path == "/healthz" || path == "/readyz";
}

bool Routes::MayStream(std::string_view origin, std::string_view host) const
{
  if (origin.empty() || this->Options.allowOrigin == "*" || origin == this->Options.allowOrigin)
  {
    return true;
  }
  const auto scheme = origin.find("://");
  return scheme != std::string_view::npos && origin.substr(scheme + 3) == host;
}

Routes::Found Routes::Route(const HttpRequest& request, std::string_view path) const
{
  if (auto answered = this->AnswerOwn(path, this->Options.metrics))
  {
    return std::move(*answered);
  }
  auto page = ParsePagePath(path);
  if (page && (this->Options.web || page->kind == PagePath::Kind::Preview))
  {
    return this->FindPage(request, std::move(*page));
  }
  if (path == "/api" || path.substr(0, 5) == "/api/")
  {
    return this->FindApi(request, path);
  }
  const bool isForRobots = path == "/robots.txt" || path == "/sitemap.xml";
  if (isForRobots && this->Options.web && !this->Options.guard && !request.root.empty())
  {
    return this->FindForRobots(request, path);
  }
  return this->FindFile(request, path);
}

// The server's own pages: its health and its metrics.
std::optional<HttpResponse> Routes::AnswerOwn(std::string_view path, bool metrics) const
{
  if (path == "/healthz")
  {
    return NoStore(200, "text/plain; charset=utf-8", "ok\n");
  }
  if (path == "/readyz")
  {
    return this->AnswerReady();
  }
  if (path == "/metrics" && metrics)
  {
    const auto lost = this->Options.lostLines ? this->Options.lostLines() : 0;
    return NoStore(200, "text/plain; version=0.0.4; charset=utf-8",
      this->Counters.Text(this->Models.Memory(), lost, this->Tiles.Use()));
  }
  return std::nullopt;
}

// Whether clients should be sent to this server: not while it stops, and not if it can serve no
// model.
HttpResponse Routes::AnswerReady() const
{
  if (this->Options.isDraining && this->Options.isDraining())
  {
    return this->Failure(503, "the server is stopping");
  }
  const auto models = this->Models.Models();
  const bool any = std::any_of(models.begin(), models.end(),
    [](const auto& model) { return model->LooksUnchanged().value_or(true); });
  return any ? NoStore(200, "text/plain; charset=utf-8", "ready\n")
             : this->Failure(503, "there is no model to serve");
}

Routes::Found Routes::FindApi(const HttpRequest& request, std::string_view path) const
{
  if (path == protocol::streamPath)
  {
    auto response =
      this->Failure(426, "this path needs a WebSocket with the subprotocol kdstream.v2");
    response.fields.emplace_back("Upgrade", "websocket");
    return response;
  }
  const auto resource = protocol::ParseResourcePath(path);
  if (!resource)
  {
    const Error& error = resource.GetError();
    return this->Failure(error.code == ErrorCode::NotFound ? 404 : 400, error.message);
  }
  auto found = this->FindOfModels(request, *resource);
  if (!this->Options.guard)
  {
    return found;
  }
  return Changed(std::move(found),
    [](HttpResponse response) // so caches do not give it to other clients
    {
      response.fields.emplace_back("Vary", "Authorization");
      return response;
    });
}

// Models and their parts, for which the client may need a token.
Routes::Found Routes::FindOfModels(
  const HttpRequest& request, const protocol::ResourcePath& resource) const
{
  auto permission = this->Admit(request.client, request.authorization);
  if (!permission)
  {
    return this->Forbidden({ 401, permission.GetError().message });
  }
  if (resource.kind == protocol::ResourcePath::Kind::ModelList)
  {
    return this->AnswerModelList(request, *permission);
  }
  if (const auto refused = permission->RefuseModel(resource.model))
  {
    return this->Forbidden(*refused);
  }
  auto model = this->Models.Find(resource.model);
  if (!model)
  {
    return this->Failure(404, "there is no model " + resource.model);
  }
  if (resource.kind == protocol::ResourcePath::Kind::Model)
  {
    return this->FindModel(request, std::move(model), permission->Detail());
  }
  if (resource.kind == protocol::ResourcePath::Kind::Notes)
  {
    Reading reading;
    reading.source = model.get();
    reading.part = "notes";
    reading.Read = [this, request, id = resource.model](bool)
    { return this->AnswerNotes(request, id); };
    return reading;
  }
  if (resource.kind == protocol::ResourcePath::Kind::Tile)
  {
    return this->FindTile(request, resource, std::move(model), std::move(*permission));
  }
  AskedBlob asked{ this->Models.FindDigest(resource.model, resource.digest), resource.blob,
    std::move(*permission), protocol::BlobName(resource.blob), {} };
  if (!asked.model)
  {
    return this->Failure(410, resource.model + " has a new digest: read its model.json again");
  }
  if (const auto refused = asked.permission.RefuseBlob(asked.model->Description(), asked.id))
  {
    return this->Forbidden(*refused);
  }
  return this->FindBlob(request, std::move(asked));
}

Routes::Found Routes::FindModel(
  const HttpRequest& request, std::shared_ptr<const ServedModel> model, ModelDetail detail) const
{
  const auto answer = [this, request, detail](const ServedModel& asked, const Status& status)
  {
    if (!status)
    {
      const auto refusal = RefuseModel(asked.Description().id, status.GetError());
      return this->Failure(refusal.status, refusal.message);
    }
    auto body = asked.Json(detail);
    auto tag = TagOf(*body);
    return Cacheable(request, "application/json", std::move(body), std::move(tag), revalidate);
  };
  if (const auto unchanged = model->LooksUnchanged())
  {
    // If the model seems to have changed, the error is known without the disk.
    return answer(*model, *unchanged ? Status{} : model->CheckUnchanged());
  }
  Reading reading;
  reading.source = model.get();
  reading.Read = [answer, model = std::move(model)](bool)
  { return answer(*model, model->CheckUnchanged()); };
  return reading;
}

// Notes may change while the model does not, so their file is read each time.
HttpResponse Routes::AnswerNotes(const HttpRequest& request, const std::string& model) const
{
  auto notes = this->Models.ReadNotes(model);
  if (!notes)
  {
    return notes.GetError().code == ErrorCode::NotFound
             ? this->Failure(404, "there are no notes on " + model)
             : this->Failure(503, "the notes on " + model + " cannot be read now: try again");
  }
  auto tag = TagOf(**notes);
  return Cacheable(request, "application/json", std::move(*notes), std::move(tag), revalidate);
}

// A client that already has exactly these bytes gets none, nor does a client whose range lies
// beyond them. Neither counts against a quota.
Routes::Found Routes::FindBlob(const HttpRequest& request, AskedBlob asked) const
{
  asked.tag = TagOfBlob(asked.model->Description().digest, asked.name);
  asked.isCounted = asked.permission.IsCounted(asked.id);
  asked.isKnown = request.method == "HEAD" || NamesTag(request.ifNoneMatch, asked.tag);
  if (auto blob = asked.isCounted ? nullptr : asked.model->FindBlob(asked.id))
  {
    return this->AnswerWhole(request, asked, blob, blob->size());
  }
  Reading reading;
  const bool mayCount = asked.isCounted && !asked.isKnown;
  reading.counts = !mayCount ? Counts::No : request.range.empty() ? Counts::Yes : Counts::Perhaps;
  reading.source = asked.model.get();
  reading.part = asked.name;
  reading.Read = [this, request, asked = std::move(asked)](bool counts)
  { return this->ReadBlob(request, asked, counts); };
  return reading;
}

// Reads a blob and answers with it. Nothing if the answer would count against a quota and mayCount
// is false.
std::optional<HttpResponse> Routes::ReadBlob(
  const HttpRequest& request, const AskedBlob& asked, bool mayCount) const
{
  const auto& description = asked.model->Description();
  const auto refuse = [&](const Error& error)
  {
    const auto refusal = RefusePart(description.id, asked.name, error);
    if (refusal.IsFailure())
    {
      this->Counters.CountFailedBlob();
    }
    return this->Failure(refusal.status, refusal.message);
  };
  if (const auto ended = asked.permission.RefuseAll()) // the token may have ended meanwhile
  {
    return this->Forbidden(*ended);
  }
  // Nothing is read for an answer without bytes. For a range the whole blob is read, because the
  // checksum covers all of it.
  if (asked.isKnown || !request.range.empty())
  {
    const auto size = asked.model->BlobSize(asked.id);
    if (!size)
    {
      return refuse(size.GetError());
    }
    auto response = this->AnswerWhole(request, asked, nullptr, static_cast<std::size_t>(*size));
    if (asked.isKnown || response.status == 416)
    {
      return response;
    }
  }
  if (asked.isCounted && !mayCount)
  {
    return std::nullopt;
  }
  auto blob = asked.model->ReadBlob(asked.id);
  if (!blob)
  {
    return refuse(blob.GetError());
  }
  if (asked.isCounted)
  {
    if (const auto over =
          asked.permission.TakePartition(description, asked.id.number, (*blob)->size()))
    {
      return this->Failure(over->status, over->message, over->retryAfter);
    }
  }
  return this->AnswerWhole(request, asked, *blob, (*blob)->size());
}

// bytes: null if none are sent; `length`: their number.
HttpResponse Routes::AnswerWhole(const HttpRequest& request, const AskedBlob& asked,
  const BlobBytes& bytes, std::size_t length) const
{
  auto response = Cacheable(request, "application/octet-stream", bytes ? bytes : BytesOfText({}),
    asked.tag, this->Options.guard ? immutablePrivate : immutable);
  response.length = response.status == 200 ? length : 0;
  return Ranged(request, std::move(response));
}

// A tile counts as its piece does: a tile of the original counts as its partition.
Routes::Found Routes::FindTile(const HttpRequest& request, const protocol::ResourcePath& resource,
  std::shared_ptr<const ServedModel> model, Permission permission) const
{
  const auto& description = model->Description();
  // A hash of the whole description, because, for example, another unit changes the tiles but not
  // the digest.
  const std::string version = model->JsonHash(
    [](const std::vector<std::uint8_t>& json) { return HashOf(json, tilesFormat); });
  if (!resource.tile.isRoot && resource.digest != version)
  {
    return this->Failure(410, AnotherTileset(description.id));
  }
  const auto piece = PieceOfTile(description, resource.tile);
  if (!piece)
  {
    const Error& error = piece.GetError();
    return this->Failure(error.code == ErrorCode::Unsupported ? 501 : 404, error.message);
  }
  if (const auto refused = permission.RefuseBlob(description, *piece))
  {
    return this->Forbidden(*refused);
  }
  AskedTile asked;
  asked.model = std::move(model);
  asked.piece = *piece;
  asked.permission = std::move(permission);
  asked.wanted.version = version;
  asked.wanted.tile = resource.tile;
  asked.name = "tile " + protocol::NameOfTile(resource.tile);
  asked.tag = TagOfBlob(version, protocol::NameOfTile(resource.tile));
  if (resource.tile.isTileset)
  {
    asked.name = "tileset " + protocol::NameOfTile(resource.tile);
    asked.wanted.detail = asked.permission.Detail();
    asked.tag = TagOfBlob(version,
      protocol::NameOfTile(resource.tile) + "/" + std::string(NameOf(asked.wanted.detail)));
  }
  asked.isCounted = !resource.tile.isTileset && asked.permission.IsCounted(*piece);
  asked.isKnown = NamesTag(request.ifNoneMatch, asked.tag);
  const bool mayCount = asked.isCounted && !asked.isKnown && request.method != "HEAD";
  if (!mayCount && asked.model->LooksUnchanged() == true)
  {
    if (const auto bytes = this->Tiles.Find(asked.wanted))
    {
      return this->AnswerTile(request, asked, bytes);
    }
  }
  Reading reading;
  // An answer that counts is made by readers first; only then does it count against the quota.
  reading.counts = mayCount ? Counts::Perhaps : Counts::No;
  // Only one thread makes the tilesets of one level of detail, because the first of them takes
  // long.
  reading.isMade = true;
  reading.source = asked.model.get();
  reading.part = version + "/" +
                 (resource.tile.isTileset ? std::string(NameOf(asked.wanted.detail))
                                          : protocol::NameOfTile(resource.tile));
  reading.Read = [this, request, asked = std::move(asked)](bool counts)
  { return this->ReadTile(request, asked, counts); };
  return reading;
}

// Makes a tile and answers with it. Nothing if the answer would count against a quota and mayCount
// is false; but then the tile has been made.
std::optional<HttpResponse> Routes::ReadTile(
  const HttpRequest& request, const AskedTile& asked, bool mayCount) const
{
  const auto& description = asked.model->Description();
  const auto refuse = [&](const Error& error)
  {
    auto refusal = RefusePart(description.id, asked.name, error);
    if (refusal.IsFailure())
    {
      this->Counters.CountFailedBlob();
    }
    return this->Failure(
      refusal.status, refusal.status == 410 ? AnotherTileset(description.id) : refusal.message);
  };
  if (const auto ended = asked.permission.RefuseAll()) // the token may have ended meanwhile
  {
    return this->Forbidden(*ended);
  }
  if (const auto unchanged = asked.model->CheckUnchanged(); !unchanged)
  {
    const auto refusal = RefuseModel(description.id, unchanged.GetError());
    return asked.wanted.tile.isRoot ? this->Failure(refusal.status, refusal.message)
                                    : refuse(unchanged.GetError());
  }
  if (asked.isKnown)
  {
    return this->AnswerTile(request, asked, BytesOfText({}));
  }
  const auto bytes = this->Tiles.Get(*asked.model, asked.wanted);
  if (!bytes)
  {
    return refuse(bytes.GetError());
  }
  if (asked.isCounted && request.method != "HEAD")
  {
    if (!mayCount)
    {
      return std::nullopt;
    }
    std::uint64_t taken = 0;
    for (const auto& blob : { asked.piece, protocol::BlobId::Texture(asked.piece.number) })
    {
      const bool isThere = blob == asked.piece || description.textures;
      const auto size = isThere ? asked.model->BlobSize(blob) : Result<std::uint64_t>(0);
      if (!size)
      {
        return refuse(size.GetError());
      }
      taken += *size;
    }
    if (const auto over = asked.permission.TakePartition(description, asked.piece.number, taken))
    {
      return this->Failure(over->status, over->message, over->retryAfter);
    }
  }
  return this->AnswerTile(request, asked, *bytes);
}

HttpResponse Routes::AnswerTile(
  const HttpRequest& request, const AskedTile& asked, const BlobBytes& bytes) const
{
  const auto& tile = asked.wanted.tile;
  const bool isGuarded = this->Options.guard != nullptr;
  const char* const keep = tile.isRoot ? (isGuarded ? revalidatePrivate : revalidate)
                                       : (isGuarded ? immutablePrivate : immutable);
  return Cacheable(
    request, tile.isTileset ? "application/json" : "model/gltf-binary", bytes, asked.tag, keep);
}

// Files that search engines request, unless the web folder has files of these names.
Routes::Found Routes::FindForRobots(const HttpRequest& request, std::string_view path) const
{
  Reading reading;
  reading.source = this;
  reading.part = std::string(path);
  reading.Read = [this, request, path = std::string(path)](bool)
  {
    constexpr unsigned missing = 404;
    auto own = this->ReadFile(request, path, AcceptsGzip(request.acceptEncoding));
    if (own.status != missing)
    {
      return own;
    }
    if (path == "/robots.txt")
    {
      return this->AnswerText(request, "text/plain; charset=utf-8",
        "User-agent: *\nAllow: /\n\nSitemap: " + request.root + "sitemap.xml\n");
    }
    constexpr std::size_t most = 49'999; // addresses in a sitemap
    const auto permission = this->Admit(request.client, {});
    return this->AnswerText(request, "application/xml",
      WriteSitemap(permission ? this->SummariesFor(*permission, most) : std::vector<ModelSummary>(),
        { request.root }));
  };
  return reading;
}

std::vector<ModelSummary> Routes::SummariesFor(const Permission& permission, std::size_t most) const
{
  std::vector<ModelSummary> summaries;
  for (const auto& model : this->Models.Models())
  {
    if (summaries.size() < most && !permission.RefuseModel(model->Description().id))
    {
      summaries.push_back(Summarize(model->Description()));
    }
  }
  return summaries;
}

// Lists the models that the client may have.
HttpResponse Routes::AnswerModelList(const HttpRequest& request, const Permission& permission) const
{
  BlobBytes body;
  if (!permission.AllowsAllModels())
  {
    auto models = this->Models.Models();
    std::erase_if(models, [&permission](const auto& model)
      { return permission.RefuseModel(model->Description().id).has_value(); });
    body = this->Models.WriteList(models);
  }
  else
  {
    body = this->Models.ListJson();
  }
  auto tag = TagOf(*body);
  return Cacheable(request, "application/json", std::move(body), std::move(tag), revalidate);
}

Routes::Found Routes::FindFile(const HttpRequest& request, std::string_view path) const
{
  if (!this->Options.web)
  {
    if (path != "/")
    {
      return this->Failure(404, "there is nothing at this path");
    }
    return Whole(200, "text/plain; charset=utf-8",
      BytesOfText("kdstream-serve " + this->Options.version +
                  ": streams 3D meshes.\n\nList of models: /api/models.json\nStream for viewers: " +
                  std::string(protocol::streamPath) + " (WebSocket, " +
                  std::string(protocol::streamSubprotocol) + ")\n"));
  }
  const bool gzip = AcceptsGzip(request.acceptEncoding);
  if (const auto found = this->Options.web->Find(path, gzip))
  {
    return this->AnswerFile(request, *found);
  }
  Reading reading;
  reading.source = this;
  reading.part = std::string(path);
  reading.Read = [this, request, path = std::string(path), gzip](bool)
  { return this->ReadFile(request, path, gzip); };
  return reading;
}

HttpResponse Routes::ReadFile(const HttpRequest& request, const std::string& path, bool gzip) const
{
  const auto file = this->Options.web->Read(path, gzip);
  if (!file)
  {
    const auto code = file.GetError().code;
    // A file that is too large cannot be a file of this site. Asking again would not help, and the
    // server has not failed.
    const bool isMissing = code == ErrorCode::NotFound || code == ErrorCode::LimitExceeded;
    const unsigned status = isMissing                            ? 404
                            : code == ErrorCode::InvalidArgument ? 400
                            : code == ErrorCode::InputOutput     ? 503
                                                                 : 500;
    return this->Failure(status, file.GetError().message);
  }
  return this->AnswerFile(request, **file);
}

HttpResponse Routes::AnswerFile(const HttpRequest& request, const StaticFile& file) const
{
  auto response = Ranged(
    request, Cacheable(request, file.contentType, file.bytes, TagOf(*file.bytes), revalidate));
  if (!file.encoding.empty() && (response.status == 200 || response.status == 206))
  {
    response.fields.emplace_back("Content-Encoding", file.encoding);
  }
  if (file.varies)
  {
    response.fields.emplace_back("Vary", "Accept-Encoding");
  }
  response.fields.emplace_back("Content-Security-Policy", protocol::pagePolicy);
  response.fields.emplace_back("Referrer-Policy", "same-origin");
  return response;
}

// A model's page is answered in any case, because people follow links. If the model is unknown, or
// not for this client, the page says so; only clients with a token are told which of the two it is.
Routes::Found Routes::FindPage(const HttpRequest& request, PagePath asked) const
{
  const bool isEmbed = asked.kind == PagePath::Kind::Embed;
  EmbedRequest embed;
  if (isEmbed)
  {
    auto wanted = ParseEmbedQuery(QueryOf(request.target));
    if (!wanted)
    {
      const Error& error = wanted.GetError();
      return this->Failure(error.code == ErrorCode::Unsupported ? 501 : 400, error.message);
    }
    embed = std::move(*wanted);
    asked.model = ModelOfAddress(embed.url, request.root);
    if (request.root.empty() || asked.model.empty())
    {
      return this->Failure(404, request.root.empty()
                                  ? "the server does not know its address: start it with --address"
                                  : "url is not the address of a model here");
    }
  }
  const auto permission = this->Admit(request.client, request.authorization);
  const bool isList = asked.kind == PagePath::Kind::List;
  const auto refused = !permission ? Permission::Refused({ 401, permission.GetError().message })
                       : isList    ? std::nullopt
                                   : permission->RefuseModel(asked.model);
  auto model = refused || isList ? nullptr : this->Models.Find(asked.model);
  Reading reading;
  if (asked.kind == PagePath::Kind::Page || isList)
  {
    reading.source = this; // the folder of the web pages
    reading.part = "page";
    constexpr std::size_t most = 1000; // links, for visitors without scripts
    auto listed =
      isList && !refused ? this->SummariesFor(*permission, most) : std::vector<ModelSummary>();
    reading.Read = [this, request, asked, model, listed = std::move(listed),
                     lacking = refused ? refused->message : ""](bool)
    { return this->AnswerPage(request, asked, model.get(), listed, lacking); };
    return reading;
  }
  if (refused)
  {
    return this->Forbidden(*refused);
  }
  if (!model)
  {
    return this->Failure(404, "there is no such model");
  }
  if (isEmbed)
  {
    return this->AnswerText(request, "application/json",
      WriteEmbedAnswer(
        model->Description(), PlaceOf(asked, request.root), this->Models.AboutSite().title, embed));
  }
  if (asked.kind == PagePath::Kind::Preview &&
      !(model = this->Models.FindDigest(asked.model, asked.digest)))
  {
    return this->Failure(410, asked.model + " has a new digest: read its model.json again");
  }
  reading.isMade = asked.kind != PagePath::Kind::Manifest;
  reading.source = model.get();
  reading.part = asked.kind == PagePath::Kind::Picture   ? "picture"
                 : asked.kind == PagePath::Kind::Preview ? "preview"
                                                         : "manifest";
  reading.Read = [this, request, asked, model](bool)
  {
    switch (asked.kind)
    {
      case PagePath::Kind::Picture:
        return this->AnswerDrawn(
          request, *model, "picture.jpg", "image/jpeg", this->Pictures.Get(*model));
      case PagePath::Kind::Preview:
        return this->AnswerDrawn(
          request, *model, "preview.glb", "model/gltf-binary", PreviewOf(*model));
      default:
        return this->AnswerText(request,
          R"(application/ld+json;profile="http://iiif.io/api/presentation/4/context.json")",
          ManifestOf(this->Models, *model, PlaceOf(asked, request.root)));
    }
  };
  return reading;
}

// listed: the models on the page of all models. model: null if there is none to show. lacking: what
// the client's token lacks, or "".
HttpResponse Routes::AnswerPage(const HttpRequest& request, const PagePath& asked,
  const ServedModel* model, const std::vector<ModelSummary>& listed,
  const std::string& lacking) const
{
  const auto page = this->Options.web->Read("/");
  if (!page)
  {
    return this->Failure(503, "the viewer's page cannot be read now: try again");
  }
  const std::string_view viewer(
    reinterpret_cast<const char*>((*page)->bytes->data()), (*page)->bytes->size());
  const auto place = PlaceOf(asked, request.root);
  const auto& site = this->Models.AboutSite().title;
  HttpResponse response;
  constexpr const char* type = "text/html; charset=utf-8";
  if (model)
  {
    response =
      this->AnswerText(request, type, MakeModelPage(viewer, model->Description(), place, site));
  }
  else if (lacking.empty() && asked.kind == PagePath::Kind::List)
  {
    response = this->AnswerText(
      request, type, MakeListPage(viewer, listed, place, this->Models.AboutSite()));
  }
  else if (!lacking.empty())
  {
    this->Counters.CountRefusal(Metrics::Reason::Token);
    const auto& contact = this->Options.contact;
    response = NoStore(401, type,
      MakeRefusalPage(viewer, "A token is needed",
        "This link needs a token (" + lacking + ")." + (contact.empty() ? "" : " " + contact),
        place, site));
    response.fields.emplace_back("WWW-Authenticate", "Bearer");
  }
  else
  {
    response = NoStore(404, type,
      MakeRefusalPage(viewer, "There is no such model",
        "There is no model " + Shortened(asked.model, 128) +
          " here. It may have been removed or renamed.",
        place, site));
  }
  response.fields.emplace_back("Content-Security-Policy", protocol::pagePolicy);
  response.fields.emplace_back("Referrer-Policy", "same-origin");
  return response;
}

// Answers with a picture or file made from the model's preview.
HttpResponse Routes::AnswerDrawn(const HttpRequest& request, const ServedModel& model,
  const std::string& name, const std::string& type, Result<BlobBytes> bytes) const
{
  if (!bytes)
  {
    const Error& error = bytes.GetError();
    if (error.code == ErrorCode::NotFound || error.code == ErrorCode::Cancelled)
    {
      return this->Failure(error.code == ErrorCode::NotFound ? 404 : 503, error.message);
    }
    const auto refusal = RefusePart(model.Description().id, name, error);
    return this->Failure(refusal.status, refusal.message);
  }
  auto tag = TagOf(**bytes);
  auto response = Cacheable(request, type, std::move(*bytes), std::move(tag),
    this->Options.guard ? revalidatePrivate : revalidate);
  if (this->Options.guard)
  {
    response.fields.emplace_back("Vary", "Authorization");
  }
  return response;
}

// A text that is made for each request, and compressed if the client accepts that.
HttpResponse Routes::AnswerText(
  const HttpRequest& request, const std::string& type, const std::string& text) const
{
  constexpr int level = 6;
  const auto small =
    AcceptsGzip(request.acceptEncoding) ? GzipText(text, level) : Result<std::string>(Error{});
  auto body = BytesOfText(small ? *small : text);
  auto tag = TagOf(*body);
  auto response = Cacheable(request, type, std::move(body), std::move(tag),
    this->Options.guard ? revalidatePrivate : revalidate);
  if (small && response.status == 200)
  {
    response.fields.emplace_back("Content-Encoding", "gzip");
  }
  response.fields.emplace_back(
    "Vary", this->Options.guard ? "Accept-Encoding, Authorization" : "Accept-Encoding");
  return response;
}

HttpResponse Routes::Preflight() const
{
  HttpResponse response;
  response.status = 204;
  response.fields = { { "Access-Control-Allow-Methods", "GET, HEAD" },
    { "Access-Control-Allow-Headers", "Authorization, If-None-Match, If-Range, Range" },
    { "Access-Control-Max-Age", "86400" } };
  return response;
}

}
