// SPDX-License-Identifier: BSD-3-Clause
// What the operator of a server asks: whether it is alive, whether it is ready, and how well it
// runs.
#include "filters/protocol/Testing/AskedBlobs.h"
#include "server/http/Testing/ServerTest.h"

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Admin = ServerTest;

bool Has(const std::string& text, const std::string& line)
{
  return text.find(line) != std::string::npos;
}

}

TEST_F(Admin, MetricsAreWhereTheyBelong)
{
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  HttpTestClient client(port);
  EXPECT_EQ(client.Get("/metrics")->status, 404u);
  EXPECT_EQ(client.Get("/healthz")->status, 200u);
  HttpTestClient admin(this->AdminPort());
  const auto metrics = admin.Get("/metrics");
  ASSERT_TRUE(metrics);
  EXPECT_TRUE(Has(metrics->body, "kdstream_requests_total{status=\"404\"} 1\n")) << metrics->body;
  EXPECT_TRUE(Has(metrics->body, "kdstream_connections 1\n")) << "those of clients";
  EXPECT_EQ(admin.Get("/healthz")->body, "ok\n");
  EXPECT_EQ(admin.Get("/readyz?x")->body, "ready\n");
  for (const char* path : { "/", "/api/models.json", "/api/models/dragon/model.json" })
  {
    EXPECT_EQ(admin.Get(path)->status, 404u) << path;
  }
  EXPECT_EQ(admin.Get("/metrics", "", "POST")->status, 405u);
  EXPECT_FALSE(StreamTestClient(this->AdminPort()).Open());
  this->server->Stop();
  EXPECT_EQ(this->records.size(), 2u) << "those of clients";
}

TEST_F(Admin, MetricsAreWithTheRestWhereNothingElseIsSaid)
{
  HttpTestClient client(this->Start());
  EXPECT_EQ(client.Get("/metrics")->status, 200u);
  EXPECT_EQ(this->server->AdminUrl(), "");
}

TEST_F(Admin, AnswersThoughAllSlotsAreTakenAndWhileTheServerStops)
{
  this->options.admin = ListenAddress{};
  this->options.maximumConnections = 1;
  this->options.connectionsOfAddress = 1;
  this->options.requestsOfAddress = 1;
  this->options.allowedHosts = { "models.example" };
  const auto port = this->Start();
  HttpTestClient connected(port);
  EXPECT_EQ(connected.Get("/healthz")->status, 200u);
  EXPECT_EQ(HttpTestClient(port).Get("/healthz")->status, 429u);
  HttpTestClient admin(this->AdminPort());
  EXPECT_EQ(admin.Get("/metrics")->status, 200u);
  EXPECT_EQ(admin.Get("/readyz")->status, 200u);
  this->server->BeginDrain();
  HttpTestClient late(this->AdminPort());
  EXPECT_EQ(late.Get("/readyz")->status, 503u);
  EXPECT_EQ(HttpTestClient(this->AdminPort()).Get("/metrics")->status, 200u);
  EXPECT_EQ(HttpTestClient(this->AdminPort()).Get("/healthz")->status, 200u);
}

TEST_F(Admin, IsReadyWhileThereIsAModel)
{
  this->options.allowedHosts = { "models.example" };
  const auto status = [this]
  {
    const auto answer = HttpTestClient(this->Start()).Get("/readyz");
    this->server.reset(); // so nobody reads the models while they change
    return answer->status;
  };
  EXPECT_EQ(status(), 200u) << "of any host";
  this->model->fails = ErrorCode::Changed; // its store was overwritten, and is not yet opened again
  EXPECT_EQ(status(), 503u);
  this->catalog.Add("lucy", 3, 3, 100);
  EXPECT_EQ(status(), 200u);
  this->catalog.models.clear();
  EXPECT_EQ(status(), 503u);
}

TEST_F(Admin, CountsHowLongClientsWait)
{
  const auto port = this->Start();
  StreamTestClient stream(port);
  ASSERT_TRUE(stream.Open());
  stream.Ask({ 1, OpenRequest{ "dragon" } });
  stream.Await(1);
  stream.Ask({ 2, RegionRequest{ 1, 3, {} } }); // a region of 128 partitions
  ASSERT_TRUE(this->IsRegion(stream.Await(2), 1, 3));
  stream.Ask({ 3, AskPieces(0, { 1 }) }); // one blob, which is the first and the last
  ASSERT_TRUE(stream.Await(3).end);
  HttpTestClient client(port);
  client.Get(this->Blob(BlobId::Partition(0)));
  const auto metrics = client.Get("/metrics")->body;
  EXPECT_TRUE(Has(metrics, "kdstream_first_blob_seconds_count 2\n")) << metrics;
  EXPECT_TRUE(Has(metrics, "kdstream_first_blob_seconds_bucket{le=\"+Inf\"} 2\n"));
  EXPECT_TRUE(Has(metrics, "kdstream_last_blob_seconds_count 2\n"));
  EXPECT_TRUE(Has(metrics, "kdstream_answer_seconds_count 1\n"));
  // Opening the model, searching the region, 128 partitions, the preview, and the partition by GET:
  // one task each.
  EXPECT_TRUE(Has(metrics, "kdstream_reader_queue_length_bucket{le=\"0\"} 0\n"));
  EXPECT_TRUE(Has(metrics, "kdstream_reader_queue_length_bucket{le=\"1\"} 132\n"));
  EXPECT_TRUE(Has(metrics, "kdstream_reader_wait_seconds_count 132\n"));
}
