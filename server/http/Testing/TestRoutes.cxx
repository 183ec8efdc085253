// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Routes.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "server/http/Testing/WholeAnswer.h"
#include "server/session/Testing/MemoryCatalog.h"

#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

class Site : public testing::Test
{
protected:
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = this->catalog.Add("dragon", 1, 4, 3000);
  std::string digest = this->model->Description().digest;
  Metrics metrics;
  Routes routes{ this->catalog, this->metrics, {} };

  HttpResponse Get(const std::string& target) const
  {
    return Answer(this->routes, { "GET", target, "", "", "" });
  }
  std::string Blob(const BlobId& blob) const { return BlobPath("dragon", this->digest, blob); }

  static std::string Text(const HttpResponse& response)
  {
    const auto* data = reinterpret_cast<const char*>(response.body->data());
    return std::string(data + response.begin, response.length);
  }

  // The status, if the answer is an error in JSON.
  unsigned ErrorOf(const HttpResponse& response) const
  {
    EXPECT_EQ(response.Field("Content-Type"), "application/json");
    const auto json = nlohmann::json::parse(Text(response), nullptr, false);
    EXPECT_TRUE(json.is_object() && json["error"].is_string()) << Text(response);
    EXPECT_EQ(response.Field("Cache-Control"), "no-store");
    return response.status;
  }
};

}

TEST_F(Site, Models)
{
  for (const char* path : { "/api/models.json", "/api/models", "/api/models.json?x=1" })
  {
    const auto response = this->Get(path);
    EXPECT_EQ(response.status, 200u);
    EXPECT_EQ(response.Field("Cache-Control"), "no-cache");
    const auto models = ParseModelList(Text(response));
    ASSERT_TRUE(models);
    EXPECT_EQ(*models, std::vector{ Summarize(this->model->Description()) });
  }
  const auto response = this->Get("/api/models/dragon/model.json");
  EXPECT_EQ(*ParseModel(Text(response)), this->model->Description());
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/lucy/model.json")), 404u);
}

TEST_F(Site, NotesAreServedAsTheyAreNow)
{
  const std::string path = NotesPath("dragon");
  EXPECT_EQ(this->ErrorOf(this->Get(path)), 404u);
  const auto put = [this](std::string_view text)
  {
    this->catalog.notes.insert_or_assign(
      "dragon", std::make_shared<const std::vector<std::uint8_t>>(text.begin(), text.end()));
  };
  put("[1]");
  EXPECT_TRUE(
    std::holds_alternative<Routes::Reading>(this->routes.Find({ "GET", path, "", "", "" })))
    << "it asks a disk";
  const auto first = this->Get(path);
  EXPECT_EQ(first.status, 200u);
  EXPECT_EQ(Text(first), "[1]");
  EXPECT_EQ(first.Field("Content-Type"), "application/json");
  EXPECT_EQ(first.Field("Cache-Control"), "no-cache");
  HttpRequest again{ "GET", path, "", "", "" };
  const std::string tag(first.Field("ETag"));
  again.ifNoneMatch = tag;
  EXPECT_EQ(Answer(this->routes, again).status, 304u);
  put("[2]");
  EXPECT_EQ(Answer(this->routes, again).status, 200u) << "they have changed";
  EXPECT_EQ(Answer(this->routes, { "PUT", path, "", "", "" }).status, 405u);
  this->catalog.notes.insert_or_assign("dragon", Error{ ErrorCode::InputOutput, "secret place" });
  const auto failed = this->Get(path);
  EXPECT_EQ(this->ErrorOf(failed), 503u);
  EXPECT_EQ(Text(failed).find("secret"), std::string::npos);
  EXPECT_EQ(this->ErrorOf(this->Get(NotesPath("lucy"))), 404u);
}

TEST_F(Site, EveryBlobIsServedAsItIs)
{
  for (const auto& [id, bytes] : this->model->blobs)
  {
    const auto response = this->Get(this->Blob(id));
    ASSERT_EQ(response.status, 200u) << BlobName(id);
    EXPECT_EQ(*response.body, *bytes);
    EXPECT_EQ(response.length, bytes->size());
    EXPECT_EQ(response.Field("Content-Type"), "application/octet-stream");
    EXPECT_EQ(response.Field("Cache-Control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(response.Field("Accept-Ranges"), "bytes");
  }
}

TEST_F(Site, Errors)
{
  const std::string other(32, '0');
  EXPECT_EQ(this->ErrorOf(this->Get(BlobPath("dragon", other, BlobId::Partition(0)))), 410u);
  EXPECT_EQ(this->ErrorOf(this->Get(BlobPath("lucy", other, BlobId::Partition(0)))), 404u);
  EXPECT_EQ(this->ErrorOf(this->Get(this->Blob(BlobId::Partition(16)))), 404u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/dragon/" + this->digest + "/tree/01")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/dragon/abc/tree/1")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/%64ragon/model.json")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/../model.json")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/nothing")), 404u);
  EXPECT_EQ(this->ErrorOf(this->Get("/nothing")), 404u);
  EXPECT_EQ(this->ErrorOf(this->Get("")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("http://host/healthz")), 400u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/stream")), 426u);
  for (const char* method : { "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "get" })
  {
    const auto response = Answer(this->routes, { method, "/api/models.json", "", "", "" });
    EXPECT_EQ(this->ErrorOf(response), 405u) << method;
    EXPECT_EQ(response.Field("Allow"), "GET, HEAD");
  }
}

TEST_F(Site, ADamagedBlobIs500AndTheRestIsServed)
{
  this->model->damaged = { BlobId::Partition(3) };
  const auto response = this->Get(this->Blob(BlobId::Partition(3)));
  EXPECT_EQ(this->ErrorOf(response), 500u);
  EXPECT_NE(Text(response).find("partitions/3"), std::string::npos);
  EXPECT_EQ(Text(response).find("secret"), std::string::npos);
  EXPECT_EQ(this->Get(this->Blob(BlobId::Partition(4))).status, 200u);
  EXPECT_NE(this->metrics.Text({}).find("kdstream_failed_blobs_total 1\n"), std::string::npos);
}

TEST_F(Site, WhatMayPassIs503AndWhatHasChanged410)
{
  for (const auto code : { ErrorCode::InputOutput, ErrorCode::LimitExceeded })
  {
    this->model->fails = code;
    const auto response = this->Get(this->Blob(BlobId::Partition(3)));
    EXPECT_EQ(this->ErrorOf(response), 503u);
    EXPECT_EQ(response.Field("Retry-After"), "1");
    EXPECT_EQ(Text(response).find("secret"), std::string::npos);
    EXPECT_EQ(this->Get("/api/models/dragon/model.json").status, 200u);
  }
  EXPECT_NE(this->metrics.Text({}).find("kdstream_failed_blobs_total 2\n"), std::string::npos);
  this->model->fails = ErrorCode::Changed;
  EXPECT_EQ(this->ErrorOf(this->Get(this->Blob(BlobId::Partition(3)))), 410u);
  EXPECT_EQ(this->ErrorOf(this->Get("/api/models/dragon/model.json")), 503u);
  EXPECT_NE(this->metrics.Text({}).find("kdstream_failed_blobs_total 2\n"), std::string::npos);
}

// The thread of the event loop asks first, and must not wait for a disk.
TEST_F(Site, WhatTakesADiskIsNotAnsweredAtOnce)
{
  const auto atOnce = [this](const std::string& path)
  {
    const auto found = this->routes.Find({ "GET", path, "", "", "" });
    const auto* const answer = std::get_if<HttpResponse>(&found);
    return answer ? answer->status : 0;
  };
  const std::string description = "/api/models/dragon/model.json";
  EXPECT_EQ(atOnce(description), 200u);
  EXPECT_EQ(atOnce(this->Blob(BlobId::Partition(3))), 0u);
  this->model->inMemory = true;
  EXPECT_EQ(atOnce(this->Blob(BlobId::Partition(3))), 200u);
  this->model->unclear = true;
  EXPECT_EQ(atOnce(description), 0u);
  EXPECT_EQ(this->Get(description).status, 200u);
  EXPECT_EQ(atOnce("/readyz"), 200u) << "as far as one can see";
}

// A request is looked up only once: the second step reads, and looks nothing up again.
TEST_F(Site, WhatIsReadIsWhatWasFound)
{
  const auto path = this->Blob(BlobId::Partition(3));
  const auto bytes = *this->model->blobs.at(BlobId::Partition(3));
  const auto found = this->routes.Find({ "GET", path, "", "", "" });
  const auto* const reading = std::get_if<Routes::Reading>(&found);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->source, this->model.get());
  EXPECT_EQ(reading->part, "partitions/3");
  this->catalog.Add("dragon", 2, 4, 3000); // the model is replaced meanwhile
  const auto answer = reading->Answer();
  EXPECT_EQ(answer.status, 200u);
  EXPECT_EQ(Text(answer), std::string(bytes.begin(), bytes.end()));
  EXPECT_EQ(this->Get(path).status, 410u);
}

TEST_F(Site, WhatIsNotSentIsNotRead)
{
  const auto path = this->Blob(BlobId::Partition(3));
  const auto whole = this->Get(path);
  const auto reads = this->model->reads.load();
  const auto head = Answer(this->routes, { "HEAD", path, "", "", "" });
  EXPECT_EQ(head.status, 200u);
  EXPECT_EQ(head.length, whole.length);
  EXPECT_EQ(head.fields, whole.fields);
  const std::string tag(whole.Field("ETag"));
  EXPECT_EQ(Answer(this->routes, { "GET", path, tag, "", "" }).status, 304u);
  const auto beyond = Answer(this->routes, { "GET", path, "", "bytes=9999999-", "" });
  EXPECT_EQ(beyond.status, 416u);
  EXPECT_EQ(beyond.Field("Content-Range"), "bytes */" + std::to_string(whole.length));
  EXPECT_EQ(this->model->reads, reads);
  EXPECT_EQ(Answer(this->routes, { "GET", path, "", "bytes=0-9", "" }).length, 10u);
  EXPECT_EQ(this->model->reads, reads + 1);
  const auto missing = this->Blob(BlobId::Partition(1000));
  EXPECT_EQ(Answer(this->routes, { "HEAD", missing, "", "", "" }).status, 404u);
  EXPECT_EQ(Answer(this->routes, { "GET", missing, "*", "", "" }).status, 404u);
}

TEST_F(Site, TagsGive304)
{
  for (const std::string& path : { std::string("/api/models.json"),
         std::string("/api/models/dragon/model.json"), this->Blob(BlobId::Partition(0)) })
  {
    const auto first = this->Get(path);
    const std::string tag(first.Field("ETag"));
    ASSERT_GT(tag.size(), 2u);
    EXPECT_EQ(tag.front(), '"'); // strong
    for (const auto& field : { tag, "\"x\", " + tag, std::string("*") })
    {
      const auto again = Answer(this->routes, { "GET", path, field, "", "" });
      EXPECT_EQ(again.status, 304u);
      EXPECT_EQ(again.length, 0u);
      EXPECT_FALSE(again.body);
      EXPECT_EQ(again.Field("ETag"), tag);
      EXPECT_EQ(again.Field("Cache-Control"), first.Field("Cache-Control"));
    }
    EXPECT_EQ(Answer(this->routes, { "GET", path, "\"other\"", "", "" }).status, 200u);
  }
  EXPECT_NE(this->Get(this->Blob(BlobId::Partition(0))).Field("ETag"),
    this->Get(this->Blob(BlobId::Partition(1))).Field("ETag"));
  const auto before = std::string(this->Get("/api/models.json").Field("ETag"));
  this->catalog.Add("lucy", 2, 1, 100);
  EXPECT_NE(this->Get("/api/models.json").Field("ETag"), before);
}

TEST_F(Site, Ranges)
{
  const auto path = this->Blob(BlobId::Partition(2));
  const auto& bytes = *this->model->blobs.at(BlobId::Partition(2));
  const auto size = std::to_string(bytes.size());
  const auto part = Answer(this->routes, { "GET", path, "", "bytes=10-19", "" });
  EXPECT_EQ(part.status, 206u);
  EXPECT_EQ(part.Field("Content-Range"), "bytes 10-19/" + size);
  EXPECT_EQ(Text(part), std::string(bytes.begin() + 10, bytes.begin() + 20));

  const auto none = Answer(this->routes, { "GET", path, "", "bytes=" + size + "-", "" });
  EXPECT_EQ(none.status, 416u);
  EXPECT_EQ(none.Field("Content-Range"), "bytes */" + size);
  EXPECT_EQ(none.length, 0u);

  const std::string tag(part.Field("ETag"));
  EXPECT_EQ(Answer(this->routes, { "GET", path, "", "bytes=1-2", tag }).status, 206u);
  EXPECT_EQ(Answer(this->routes, { "GET", path, "", "bytes=1-2", "\"other\"" }).status, 200u);
  EXPECT_EQ(Answer(this->routes, { "GET", path, "", "bytes=1-2,5-6", "" }).status, 200u);
  EXPECT_EQ(Answer(this->routes, { "GET", path, tag, "bytes=1-2", "" }).status, 304u);
  EXPECT_EQ(Answer(this->routes, { "HEAD", path, "", "bytes=1-2", "" }).status, 200u);
}

TEST_F(Site, HeadIsGetWithoutABody)
{
  for (const std::string& path :
    { std::string("/api/models.json"), std::string("/nothing"), this->Blob(BlobId::Partition(0)) })
  {
    const auto get = this->Get(path);
    const auto head = Answer(this->routes, { "HEAD", path, "", "", "" });
    EXPECT_TRUE(head.omitBody);
    EXPECT_FALSE(get.omitBody);
    EXPECT_EQ(head.status, get.status);
    EXPECT_EQ(head.length, get.length);
    EXPECT_EQ(head.fields, get.fields);
  }
}

TEST_F(Site, HealthMetricsAndHome)
{
  EXPECT_EQ(Text(this->Get("/healthz")), "ok\n");
  this->metrics.CountRequest(200);
  EXPECT_NE(Text(this->Get("/metrics")).find("kdstream_requests_total{status=\"200\"} 1\n"),
    std::string::npos);
  EXPECT_NE(Text(this->Get("/")).find("/api/models.json"), std::string::npos);
}

TEST_F(Site, OriginsAreAllowedByName)
{
  EXPECT_EQ(this->Get("/healthz").Field("Access-Control-Allow-Origin"), "");
  EXPECT_TRUE(this->routes.MayStream("", "localhost:8700"));
  EXPECT_TRUE(this->routes.MayStream("http://localhost:8700", "localhost:8700"));
  EXPECT_FALSE(this->routes.MayStream("http://localhost:8701", "localhost:8700"));
  EXPECT_FALSE(this->routes.MayStream("https://example.org", "localhost:8700"));
  EXPECT_FALSE(this->routes.MayStream("null", "localhost:8700"));

  const Routes named(this->catalog, this->metrics, { "https://example.org", {}, "" });
  const auto answer = Answer(named, { "GET", "/api/nothing", "", "", "" });
  EXPECT_EQ(answer.Field("Access-Control-Allow-Origin"), "https://example.org");
  EXPECT_EQ(answer.Field("Vary"), "Origin");
  EXPECT_TRUE(named.MayStream("https://example.org", "localhost:8700"));
  EXPECT_FALSE(named.MayStream("https://example.com", "localhost:8700"));
  const auto preflight = Answer(named, { "OPTIONS", "/api/models.json", "", "", "" });
  EXPECT_EQ(preflight.status, 204u);
  EXPECT_EQ(preflight.Field("Access-Control-Allow-Methods"), "GET, HEAD");
  EXPECT_EQ(preflight.Field("Access-Control-Allow-Origin"), "https://example.org");

  const Routes any(this->catalog, this->metrics, { "*", {}, "" });
  EXPECT_EQ(Answer(any, { "GET", "/healthz", "", "", "" }).Field("Vary"), "");
  EXPECT_TRUE(any.MayStream("https://example.com", "localhost:8700"));
}

namespace
{

// A site with a page of two files, one of which also exists as gzip.
class Page : public Site
{
protected:
  const fixtures::TemporaryFolder folder;
  std::string plain = std::string(1000, 'p'), packed = std::string(100, 'z');
  std::optional<Routes> site;

  void SetUp() override
  {
    std::ofstream(this->folder / "index.html") << this->plain;
    std::ofstream(this->folder / "index.html.gz") << this->packed;
    std::ofstream(this->folder / "kdstream.wasm") << "wasm";
    this->site.emplace(
      this->catalog, this->metrics, RouteOptions{ "", *StaticFiles::Open(this->folder.Path), "1" });
  }

  HttpResponse Ask(HttpRequest request) const { return Answer(*this->site, request); }
  static HttpRequest Gzip(const std::string& method, const std::string& tag = "",
    const std::string& range = "", const std::string& ifRange = "")
  {
    return { method, "/", tag, range, ifRange, "gzip, br" };
  }
};

}

TEST_F(Page, GoesAsGzipToThoseWhoTakeIt)
{
  const auto plain_ = this->Ask({ "GET", "/", "", "", "", "gzip;q=0, br" });
  EXPECT_EQ(Text(plain_), this->plain);
  EXPECT_EQ(plain_.Field("Content-Encoding"), "");
  EXPECT_EQ(plain_.Field("Vary"), "Accept-Encoding");
  const auto packed_ = this->Ask(Gzip("GET"));
  EXPECT_EQ(Text(packed_), this->packed);
  EXPECT_EQ(packed_.Field("Content-Encoding"), "gzip");
  EXPECT_EQ(packed_.Field("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(packed_.Field("Vary"), "Accept-Encoding");
  EXPECT_NE(packed_.Field("ETag"), plain_.Field("ETag"));
  EXPECT_EQ(packed_.Field("ETag").front(), '"') << "strong";
  EXPECT_EQ(packed_.Field("Cache-Control"), "no-cache");

  const auto wasm = this->Ask({ "GET", "/kdstream.wasm", "", "", "", "gzip" });
  EXPECT_EQ(Text(wasm), "wasm");
  EXPECT_EQ(wasm.Field("Content-Type"), "application/wasm");
  EXPECT_EQ(wasm.Field("Content-Encoding"), "");
  EXPECT_EQ(wasm.Field("Vary"), "");
}

TEST_F(Page, TheScriptOfOtherPagesIsForAnyOrigin)
{
  std::ofstream(this->folder / "embed.js") << "script";
  EXPECT_EQ(
    this->Ask({ "GET", "/embed.js", "", "", "" }).Field("Access-Control-Allow-Origin"), "*");
  EXPECT_EQ(
    this->Ask({ "GET", "/embed.js?1", "", "", "" }).Field("Access-Control-Allow-Origin"), "*");
  EXPECT_EQ(this->Ask({ "GET", "/", "", "", "" }).Field("Access-Control-Allow-Origin"), "");
  const Routes named(this->catalog, this->metrics,
    { "https://example.org", *StaticFiles::Open(this->folder.Path), "1" });
  const auto answer = Answer(named, { "GET", "/embed.js", "", "", "" });
  EXPECT_EQ(answer.Field("Access-Control-Allow-Origin"), "*");
  EXPECT_EQ(answer.Field("Vary"), "") << "it is the same for all";
}

TEST_F(Page, GzipKeepsHeadTagsAndRangesRight)
{
  const auto get = this->Ask(Gzip("GET"));
  const auto head = this->Ask(Gzip("HEAD"));
  EXPECT_TRUE(head.omitBody);
  EXPECT_EQ(head.fields, get.fields);
  EXPECT_EQ(head.length, this->packed.size());

  const std::string tag(get.Field("ETag"));
  const std::string plainTag(this->Ask({ "GET", "/", "", "", "" }).Field("ETag"));
  const auto known = this->Ask(Gzip("GET", tag));
  EXPECT_EQ(known.status, 304u);
  EXPECT_EQ(known.Field("ETag"), tag);
  EXPECT_EQ(known.Field("Vary"), "Accept-Encoding");
  EXPECT_EQ(known.Field("Content-Encoding"), "");
  EXPECT_EQ(this->Ask(Gzip("GET", plainTag)).status, 200u) << "the other one's tag";
  EXPECT_EQ(this->Ask({ "GET", "/", tag, "", "" }).status, 200u) << "the other one's tag";

  // A range counts in the bytes that are sent, and its tag is the tag of these bytes.
  const auto part = this->Ask(Gzip("GET", "", "bytes=90-"));
  EXPECT_EQ(part.status, 206u);
  EXPECT_EQ(part.Field("Content-Range"), "bytes 90-99/100");
  EXPECT_EQ(part.Field("Content-Encoding"), "gzip");
  EXPECT_EQ(part.Field("ETag"), tag);
  EXPECT_EQ(Text(part), std::string(10, 'z'));
  EXPECT_EQ(this->Ask(Gzip("GET", "", "bytes=90-", plainTag)).status, 200u);
  const auto none = this->Ask(Gzip("GET", "", "bytes=100-"));
  EXPECT_EQ(none.status, 416u);
  EXPECT_EQ(none.Field("Content-Range"), "bytes */100");
  EXPECT_EQ(none.Field("Content-Encoding"), "");
}

TEST_F(Page, MayLoadNothingFromElsewhere)
{
  for (const HttpRequest& request :
    { HttpRequest{ "GET", "/", "", "", "" }, Gzip("GET"), Gzip("HEAD"), Gzip("GET", "*") })
  {
    const auto answer = this->Ask(request);
    EXPECT_EQ(answer.Field("Content-Security-Policy"),
      "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self' ws: wss:; "
      "img-src 'self' data:; style-src 'self'; object-src 'none'; base-uri 'none'");
    EXPECT_EQ(answer.Field("Referrer-Policy"), "same-origin");
    EXPECT_EQ(answer.Field("X-Content-Type-Options"), "nosniff");
  }
}
