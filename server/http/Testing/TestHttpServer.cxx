// SPDX-License-Identifier: BSD-3-Clause
// The server on real sockets: behaviour that the routes cannot show by themselves.
#include "Testing/Fixtures/Eventually.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/Testing/AskedBlobs.h"
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/Testing/ServerTest.h"

#include <thread>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Server = ServerTest;

}

TEST_F(Server, AnswersManyRequestsOnOneConnection)
{
  HttpTestClient client(this->Start());
  const auto models = client.Get("/api/models.json");
  ASSERT_TRUE(models);
  EXPECT_EQ(models->status, 200u);
  EXPECT_EQ(ParseModelList(models->body)->at(0).id, "dragon");
  EXPECT_FALSE(models->Field("Date").empty());
  for (const auto& [id, bytes] : this->model->blobs)
  {
    const auto blob = client.Get(this->Blob(id));
    ASSERT_TRUE(blob);
    EXPECT_EQ(blob->body, std::string(bytes->begin(), bytes->end()));
  }
  const auto tag = models->Field("ETag");
  const auto unchanged = client.Get("/api/models.json", "If-None-Match: " + tag + "\r\n");
  ASSERT_TRUE(unchanged);
  EXPECT_EQ(unchanged->status, 304u);
  EXPECT_TRUE(unchanged->body.empty());
  const auto part = client.Get(this->Blob(BlobId::Partition(0)), "Range: bytes=5-9\r\n");
  ASSERT_TRUE(part);
  EXPECT_EQ(part->status, 206u);
  const auto& whole = *this->model->blobs.at(BlobId::Partition(0));
  EXPECT_EQ(part->body, std::string(whole.begin() + 5, whole.begin() + 10));
  EXPECT_EQ(client.Get(this->Blob(BlobId::Partition(0)), "Range: bytes=999999-\r\n")->status, 416u);
  const auto head = client.Get(this->Blob(BlobId::Partition(0)), "", "HEAD");
  ASSERT_TRUE(head);
  EXPECT_EQ(head->Field("Content-Length"), std::to_string(whole.size()));
  EXPECT_EQ(client.Get("/api/nothing")->status, 404u);
  EXPECT_EQ(client.Get("/healthz", "", "POST")->status, 405u);
  EXPECT_EQ(client.Get("/healthz")->body, "ok\n");
  this->server->Stop(); // an answer is logged after it has been sent
  EXPECT_EQ(this->records.size(), this->model->blobs.size() + 8);
  EXPECT_EQ(this->records[0].target, "/api/models.json");
  EXPECT_EQ(this->records[0].bytes, models->body.size());
  EXPECT_EQ(this->records[0].client, "127.0.0.1");
}

TEST_F(Server, WantOfMemoryIsReportedAndTheConnectionGoesOn)
{
  const auto port = this->Start();
  HttpTestClient client(port);
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);

  this->model->throws = true;
  const auto refused = client.Get(this->Blob(BlobId::Partition(0)));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 503u);
  EXPECT_EQ(refused->Field("Retry-After"), "1");
  stream.Ask({ 2, RegionRequest{ 1, 1, {} } });
  const auto error = stream.Await(2).error;
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, 503);
  stream.Ask({ 3, AskPartitions({ 0 }) });
  const auto missing = stream.Await(3);
  ASSERT_EQ(missing.blobErrors.size(), 1u);
  EXPECT_EQ(missing.blobErrors[0].code, 503);
  EXPECT_TRUE(missing.end);

  this->model->throws = false;
  EXPECT_EQ(client.Get(this->Blob(BlobId::Partition(0)))->status, 200u);
}

TEST_F(Server, ADiskThatHangsDelaysOnlyThoseWhoReadIt)
{
  this->options.threads = 1;
  this->options.readers = 3;
  const auto port = this->Start();
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  ASSERT_TRUE(stream.Await(1).opened);

  this->model->diskHangs = true;
  HttpTestClient reader(port);
  reader.Send("GET " + this->Blob(BlobId::Partition(0)) + " HTTP/1.1\r\nHost: x\r\n\r\n");
  stream.Ask({ 2, RegionRequest{ 1, 1, {} } });
  EXPECT_TRUE(fixtures::Eventually([&] { return this->model->hanging == 2; }));
  HttpTestClient other(port);
  EXPECT_EQ(other.Get("/healthz")->body, "ok\n");
  EXPECT_EQ(other.Get("/api/models/dragon/model.json")->status, 200u);
  stream.Ask({ 2, CancelRequest{} });
  const auto cancelled = stream.Await(2);
  ASSERT_TRUE(cancelled.end);
  EXPECT_TRUE(cancelled.end->cancelled);
  const auto metrics = other.Get("/metrics")->body;
  EXPECT_NE(metrics.find("kdstream_reader_wait_seconds_count 3\n"), std::string::npos) << metrics;
  EXPECT_NE(metrics.find("kdstream_reader_queue 0\n"), std::string::npos);

  this->model->diskHangs = false;
  this->model->diskHangs.notify_all();
  const auto blob = reader.Receive();
  ASSERT_TRUE(blob);
  EXPECT_EQ(blob->body.size(), this->model->blobs.at(BlobId::Partition(0))->size());
  stream.Ask({ 3, RegionRequest{ 64, 1, {} } });
  EXPECT_TRUE(this->IsRegion(stream.Await(3), 64, 1));
}

TEST_F(Server, AnswersPipelinedRequestsInOrder)
{
  HttpTestClient client(this->Start());
  std::string burst;
  for (std::uint32_t p = 0; p < 50; ++p)
  {
    burst += "GET " + this->Blob(BlobId::Partition(p)) + " HTTP/1.1\r\nHost: x\r\n\r\n";
  }
  std::thread sender([&] { client.Send(burst); });
  for (std::uint32_t p = 0; p < 50; ++p)
  {
    const auto blob = client.Receive();
    ASSERT_TRUE(blob);
    EXPECT_EQ(blob->body.size(), this->model->blobs.at(BlobId::Partition(p))->size());
  }
  sender.join();
}

TEST_F(Server, ClosesWhenAskedTo)
{
  const auto port = this->Start();
  HttpTestClient client(port);
  EXPECT_EQ(client.Get("/healthz", "Connection: close\r\n")->status, 200u);
  EXPECT_TRUE(client.Ends());
  HttpTestClient old(port);
  old.Send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.Receive()->status, 200u);
  EXPECT_TRUE(old.Ends());
}

TEST_F(Server, RefusesWhatIsNotARequest)
{
  const auto port = this->Start();
  const auto statusOf = [port](const std::string& bytes) -> unsigned
  {
    HttpTestClient client(port);
    client.Send(bytes);
    const auto response = client.Receive();
    EXPECT_TRUE(client.Ends()) << bytes.substr(0, 40);
    return response ? response->status : 0;
  };
  EXPECT_EQ(statusOf("nonsense\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf(std::string("\x16\x03\x01\x02\x00\r\n\r\n", 9)), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/3.7\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\n\r\n"), 400u); // no host
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /a b HTTP/1.1\r\nHost: a\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nX y: b\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf("GET /healthz HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello"), 413u);
  EXPECT_EQ(
    statusOf(
      "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n0\r\n\r\n"),
    413u);
  EXPECT_EQ(
    statusOf("GET / HTTP/1.1\r\nHost: a\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"), 431u);
  EXPECT_EQ(statusOf("GET /" + std::string(20000, 'x') + " HTTP/1.1\r\nHost: a\r\n\r\n"), 431u);
}

// Requests that a proxy could read differently from the server, or for whose end the server would
// wait.
TEST_F(Server, RefusesWhatIsMoreThanOneRequest)
{
  const auto port = this->Start();
  const auto answerTo = [port](const std::vector<std::string>& parts)
  {
    HttpTestClient client(port);
    for (const auto& part : parts)
    {
      client.Send(part);
    }
    const auto response = client.Receive();
    EXPECT_TRUE(client.Ends());
    return response ? std::to_string(response->status) + " " + response->body : "none";
  };
  const std::string start = "GET /healthz HTTP/1.1\r\nHost: a\r\n";
  const std::string body = "413 {\"error\":\"requests with a body are not accepted\"}\n";
  EXPECT_EQ(answerTo({ start + "Transfer-Encoding: chunked\r\n\r\n" }), body)
    << "which does not come";
  EXPECT_EQ(answerTo({ start + "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n" }), body);
  EXPECT_EQ(answerTo({ start + "Transfer-Encoding: gzip\r\n\r\n" }), body);
  EXPECT_EQ(answerTo({ start + "Content-Length: 5\r\n\r\n" }), body);
  const std::string folded = "400 {\"error\":\"the request is not HTTP: bad obs-fold\"}\n";
  EXPECT_EQ(answerTo({ start + "X: a\r\n b\r\n\r\n" }), folded);
  EXPECT_EQ(answerTo({ start, "X: a\r\n", "\tb\r\n\r\n" }), folded);
  EXPECT_EQ(answerTo({ "GET /healthz HTTP/1.1\r\n Host: a\r\n\r\n" }), folded);
}

TEST_F(Server, TakesRequestsInEveryFormOfTheStandard)
{
  this->options.allowedHosts = { "example.com" };
  const auto port = this->Start();
  HttpTestClient client(port);
  const auto status = [&client](const std::string& bytes)
  {
    client.Send(bytes);
    const auto response = client.Receive();
    return response ? response->status : 0;
  };
  const std::string list = "/api/models.json HTTP/1.1\r\nHost: ";
  EXPECT_EQ(status("\r\nGET " + list + "example.com\r\n\r\n"), 200u) << "after an empty line";
  EXPECT_EQ(status("GET http://example.com" + list + "other.example\r\n\r\n"), 200u)
    << "the target's host counts";
  EXPECT_EQ(status("GET HTTP://EXAMPLE.COM:80" + list + "example.com\r\n\r\n"), 200u);
  EXPECT_EQ(status("GET http://other.example/healthz HTTP/1.1\r\nHost: a\r\n\r\n"), 200u);
  EXPECT_EQ(status("GET http://other.example" + list + "example.com\r\n\r\n"), 421u);
  HttpTestClient twice(port);
  twice.Send("\r\n\r\nGET " + list + "example.com\r\n\r\n");
  EXPECT_EQ(twice.Receive()->status, 400u) << "one such line";
}

TEST_F(Server, HalfARequestIsLogged)
{
  this->options.requestTimeout = std::chrono::milliseconds(50);
  const auto port = this->Start();
  {
    HttpTestClient idle(port); // sends no request
  }
  HttpTestClient slow(port);
  slow.Send("GET /a HTTP/1.1\r\nHost: a\r\n");
  EXPECT_TRUE(slow.Ends());
  const auto late = this->AwaitRecord("/a");
  EXPECT_EQ(late.method, "GET");
  EXPECT_EQ(late.status, 408u);
  EXPECT_EQ(late.bytes, 0u);
  this->server.reset();
  this->options.requestTimeout = std::chrono::milliseconds(100000);
  const auto next = this->Start();
  HttpTestClient half(next);
  half.Send("GET /b");
  half.EndOutput();
  const auto answer = half.Receive();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 400u);
  EXPECT_EQ(answer->body, "{\"error\":\"the request ends inside its header\"}\n");
  EXPECT_EQ(this->AwaitRecord("-").status, 400u);
  EXPECT_EQ(this->records.size(), 2u) << "none of who asked for nothing";
}

TEST_F(Server, SurvivesHostileBytes)
{
  // Short, as some requests are incomplete.
  this->options.requestTimeout = std::chrono::milliseconds(100);
  const auto port = this->Start();
  RandomMessages random(13);
  const std::string good =
    "GET " + this->Blob(BlobId::Partition(1)) +
    " HTTP/1.1\r\nHost: a\r\nRange: bytes=1-5\r\nIf-None-Match: \"x\", W/\"y\"\r\n"
    "Connection: close\r\n\r\n";
  for (int i = 0; i < 300; ++i)
  {
    HttpTestClient client(port);
    client.Send(random.Mutated(good) + "\r\n\r\n");
    client.Receive();
  }
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->status, 200u);
}

TEST_F(Server, AnswersForTheHostsThatAreSpecified)
{
  this->options.allowedHosts = { "models.example", "[::1]", "dotted.example." };
  const auto port = this->Start();
  const auto statusFor = [port](const std::string& host, const std::string& target = "/")
  {
    HttpTestClient client(port);
    client.Send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    const auto response = client.Receive();
    return response ? response->status : 0;
  };
  EXPECT_EQ(statusFor("models.example"), 200u);
  EXPECT_EQ(statusFor("Models.Example:8700"), 200u);
  EXPECT_EQ(statusFor("models.example."), 200u) << "the same name";
  EXPECT_EQ(statusFor("models.example.:8700"), 200u);
  EXPECT_EQ(statusFor("dotted.example"), 200u);
  EXPECT_EQ(statusFor("[::1]:8700"), 200u);
  EXPECT_EQ(statusFor("[::1]"), 200u);
  for (const char* wrong :
    { "evil.example", "models.example.evil", "models.example..", ".", "127.0.0.1", "", ":80" })
  {
    EXPECT_EQ(statusFor(wrong), 421u) << wrong;
  }
  for (const char* malformed : { "]", "[::", "models.example:x", "evil@models.example" })
  {
    EXPECT_EQ(statusFor(malformed), 400u) << malformed;
  }
  EXPECT_EQ(statusFor("10.0.0.7", "/healthz"), 200u);
}

// A stranger's page may have a host name that leads to this machine (DNS rebinding).
TEST_F(Server, AnswersNoStrangersNameAtLoopback)
{
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  const auto admin = this->AdminPort();
  const auto statusFor =
    [](std::uint16_t at, const std::string& host, const std::string& target = "/")
  {
    HttpTestClient client(at);
    client.Send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    const auto response = client.Receive();
    return response ? response->status : 0;
  };
  for (const char* own : { "127.0.0.1", "localhost:8700", "[::1]:8700", "x", "models.localhost." })
  {
    EXPECT_EQ(statusFor(port, own), 200u) << own;
    EXPECT_EQ(statusFor(admin, own, "/metrics"), 200u) << own;
  }
  for (const char* foreign : { "evil.example", "evil.example:8700", "127.0.0.1.evil.example." })
  {
    EXPECT_EQ(statusFor(port, foreign), 421u) << foreign;
    EXPECT_EQ(statusFor(admin, foreign, "/metrics"), 421u) << foreign;
    EXPECT_EQ(statusFor(port, foreign, "/healthz"), 200u) << foreign;
    EXPECT_EQ(statusFor(admin, foreign, "/readyz"), 200u) << foreign;
    HttpTestClient client(port);
    client.Send("GET http://" + std::string(foreign) + "/ HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(client.Receive()->status, 421u) << foreign;
  }
}

TEST_F(Server, RefusesHostsThatAreMalformed)
{
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  const auto admin = this->AdminPort();
  const auto statusOf = [](std::uint16_t at, const std::string& bytes)
  {
    HttpTestClient client(at);
    client.Send(bytes);
    const auto response = client.Receive();
    return response ? response->status : 0;
  };
  const auto ask = [](const std::string& target, const std::string& host)
  { return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n"; };
  for (const char* malformed : { "evil.example/.localhost", "evil.example#.localhost",
         "x.localhost:80@evil.example", "[evil.example]", "[::1].evil.example", "localhost:80:90",
         "localhost:abc", "evil.example localhost" })
  {
    EXPECT_EQ(statusOf(port, ask("/", malformed)), 400u) << malformed;
    EXPECT_EQ(statusOf(admin, ask("/metrics", malformed)), 400u) << malformed;
    EXPECT_EQ(statusOf(admin, ask("/healthz", malformed)), 400u) << malformed;
  }
  EXPECT_EQ(statusOf(port, ask("http://evil.example#.localhost/", "localhost")), 400u);
  EXPECT_EQ(statusOf(port, ask("http://localhost/", "localhost:abc")), 400u);
  for (const char* nobody : { "", ":8700", "." })
  {
    EXPECT_EQ(statusOf(port, ask("/", nobody)), 421u) << nobody;
    EXPECT_EQ(statusOf(admin, ask("/metrics", nobody)), 421u) << nobody;
    EXPECT_EQ(statusOf(port, ask("/healthz", nobody)), 200u) << nobody;
  }
  const std::string two = "GET /metrics HTTP/1.1\r\nHost: localhost\r\nHost: a\r\n\r\n";
  EXPECT_EQ(statusOf(admin, two), 400u);
  EXPECT_EQ(statusOf(admin, "GET /metrics HTTP/1.1\r\n\r\n"), 400u);
  EXPECT_EQ(statusOf(admin, "GET /metrics HTTP/1.0\r\n\r\n"), 200u) << "which has no such field";
  EXPECT_EQ(statusOf(port, "GET / HTTP/1.0\r\n\r\n"), 200u);
}

TEST_F(Server, AHostThatIsAllowedIsTakenByTheAdministratorToo)
{
  this->options.admin = ListenAddress{};
  this->options.allowedHosts = { "models.example" };
  const auto port = this->Start();
  const auto admin = this->AdminPort();
  const auto statusFor = [](std::uint16_t at, const std::string& host)
  {
    HttpTestClient client(at);
    client.Send("GET /metrics HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.Receive()->status;
  };
  EXPECT_EQ(statusFor(port, "127.0.0.1"), 421u);
  EXPECT_EQ(statusFor(admin, "127.0.0.1:9100"), 200u) << "who scrapes it";
  EXPECT_EQ(statusFor(admin, "models.example"), 200u);
  EXPECT_EQ(statusFor(admin, "evil.example"), 421u);
}

TEST_F(Server, ReportsWhyItCannotStart)
{
  const auto port = this->Start();
  HttpServerOptions taken;
  taken.address.port = port;
  const auto second = HttpServer::Start(this->catalog, taken);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.GetError().code, ErrorCode::InputOutput);
  HttpServerOptions nowhere;
  nowhere.address.host = "no address at all";
  EXPECT_FALSE(HttpServer::Start(this->catalog, nowhere));
  HttpServerOptions secret;
  secret.tlsCertificate = "/nonexistent/cert.pem";
  secret.tlsKey = "/nonexistent/key.pem";
  EXPECT_FALSE(HttpServer::Start(this->catalog, secret));
}
