// SPDX-License-Identifier: BSD-3-Clause
// Models of a server as VTK gets them: the same as from a reader of the store, and only what is
// needed is fetched.
#include "filters/adapter/Testing/ReportedErrors.h"
#include "server/access/Testing/ForgedToken.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"
#include "viewer/client/Testing/TorusCatalog.h"
#include "viewer/sources/Testing/Cxx/ModelSourceTools.h"

#include <vtkCompositeDataPipeline.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationObjectBaseKey.h>
#include <vtkKdStoreReader.h>
#include <vtkKdStreamSource.h>
#include <vtkKdTreePartition.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <future>
#include <iostream>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using fixtures::TemporaryFolder;

class TestKdStreamSource : public ::testing::Test
{
protected:
  void SetUp() override
  {
    BuildTo(this->File, this->Sphere, 200);
    this->Serve(std::make_unique<StoreCatalog>(
      this->Models.Path, [](const std::filesystem::path&, const std::string&) {}));
  }
  void Serve(std::unique_ptr<Catalog> models, std::shared_ptr<TokenGuard> guard = nullptr)
  {
    this->Server.reset();
    this->Served = std::move(models);
    if (auto* const stores = dynamic_cast<StoreCatalog*>(this->Served.get()))
    {
      ASSERT_TRUE(stores->Reload());
    }
    HttpServerOptions options;
    options.drainTimeout = std::chrono::milliseconds(100);
    options.guard = std::move(guard);
    auto server = HttpServer::Start(*this->Served, options);
    ASSERT_TRUE(server) << server.GetError().message;
    this->Server = std::move(*server);
    this->Source->SetUrl("http://127.0.0.1:" + std::to_string(this->Server->Port()));
  }
  vtkDataObject* Update()
  {
    this->Source->Update();
    return this->Source->GetOutputDataObject(0);
  }
  std::string Refusal()
  {
    FilterObserver heard(this->Source);
    this->Source->Modified();
    EXPECT_TRUE(ContentOf(this->Update(), true).points.empty());
    return heard.error;
  }

  const Mesh Sphere = fixtures::DisplacedSphere(6);
  TemporaryFolder Models, Folder;
  const std::filesystem::path File = this->Models / "sphere.kds";
  std::unique_ptr<Catalog> Served;
  std::unique_ptr<HttpServer> Server;
  vtkNew<vtkKdStreamSource> Source;
};

TEST_F(TestKdStreamSource, PartitionsAreThoseOfTheFilterToTheBit)
{
  const PolyData mesh = AsPolyData(this->Sphere);
  vtkNew<vtkKdTreePartition> filter;
  filter->SetInputData(mesh);
  filter->SetVerticesPerPartition(200);
  filter->Update();
  const unsigned int count = filter->GetOutput()->GetNumberOfPartitions();
  ASSERT_EQ(count, 128u);
  vtkDataObject* const output = this->Update();
  ASSERT_EQ(LoadedPartitions(output), count);
  for (unsigned int i = 0; i < count; ++i)
  {
    for (const bool marked : { false, true })
    {
      EXPECT_TRUE(
        ContentOfPartition(output, i, marked) == ContentOfPartition(filter->GetOutput(), i, marked))
        << i;
    }
  }
}

TEST_F(TestKdStreamSource, GivesWhatAReaderOfTheStoreGives)
{
  vtkNew<vtkKdStoreReader> reader;
  reader->SetFileName(this->File.c_str());
  const double point[3] = { 0.5, 0.5, 0.9 };
  this->Source->BoundsOfPartitionsOn();
  for (vtkKdModelSource* const each :
    { static_cast<vtkKdModelSource*>(this->Source), static_cast<vtkKdModelSource*>(reader) })
  {
    each->SetRegionPoint(point);
    each->AddPartition(7);
    each->AddPartition(100);
  }
  for (const int content : { vtkKdModelSource::Original, vtkKdModelSource::Level,
         vtkKdModelSource::Partitions, vtkKdModelSource::Region, vtkKdModelSource::View })
  {
    for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
    {
      for (vtkKdModelSource* const each :
        { static_cast<vtkKdModelSource*>(this->Source), static_cast<vtkKdModelSource*>(reader) })
      {
        each->SetContent(content);
        each->SetOutputType(type);
        each->SetCameraPosition(0, 0, 2);
        each->UpdatePiece(content == vtkKdModelSource::View ? 0 : 1, 2, 1);
      }
      EXPECT_TRUE(ContentOf(this->Source->GetOutputDataObject(0), true) ==
                  ContentOf(reader->GetOutputDataObject(0), true))
        << content << type;
    }
  }
  this->Source->SetContentToOriginal();
  this->Source->SetOutputTypeToPartitionedDataSet();
  this->Source->UpdateInformation();
  auto* const reported =
    vtkPartitionedDataSet::SafeDownCast(this->Source->GetOutputInformation(0)->Get(
      vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA()));
  ASSERT_NE(reported, nullptr);
  EXPECT_EQ(reported->GetNumberOfPartitions(), 128u);
}

TEST_F(TestKdStreamSource, FetchesOnlyWhatIsAskedFor)
{
  this->Serve(std::make_unique<TorusCatalog>());
  const auto& model = *dynamic_cast<TorusCatalog&>(*this->Served).model;
  this->Source->SetContentToLevel();
  EXPECT_GT(ContentOf(this->Update()).cells.size(), 1000u);
  EXPECT_EQ(model.TakeRead().size(), 1u); // the preview
  this->Source->SetContentToPartitions();
  this->Source->AddPartition(3);
  EXPECT_EQ(LoadedPartitions(this->Update()), 1u);
  EXPECT_EQ(model.TakeRead(), std::vector<std::string>{ "partitions/3" });
}

TEST_F(TestKdStreamSource, WhatIsKeptIsThereWithoutTheServer)
{
  this->Source->SetCacheFolder((this->Folder / "kept").string());
  this->Source->SetContentToPartitions();
  this->Source->AddPartition(3);
  const Content seen = ContentOf(this->Update());
  ASSERT_GT(seen.cells.size(), 100u);
  const std::string url = this->Source->GetUrl();
  this->Server.reset();
  vtkNew<vtkKdStreamSource> later;
  later->SetUrl(url);
  later->SetCacheFolder((this->Folder / "kept").string());
  later->SetContentToPartitions();
  later->AddPartition(3);
  later->Update();
  EXPECT_TRUE(ContentOf(later->GetOutputDataObject(0)) == seen);
  later->AddPartition(4);
  FilterObserver heard(later);
  later->Update();
  EXPECT_NE(
    heard.error.find("partitions/4 cannot be loaded: it is not in the cache"), std::string::npos)
    << heard.error;
}

TEST_F(TestKdStreamSource, ErrorsNameTheServerAndWhatIsWrong)
{
  vtkNew<vtkKdStreamSource> none;
  {
    FilterObserver heard(none);
    none->UpdateInformation();
    EXPECT_EQ(heard.error, "") << "before an address is given";
    none->Update();
    EXPECT_NE(heard.error.find("): no Url is set"), std::string::npos) << heard.error;
  }
  this->Source->SetModelId("cube");
  EXPECT_NE(this->Refusal().find("there is no model cube; there are sphere"), std::string::npos);
  BuildTo(this->Models / "other.kds", fixtures::Torus(20, 10), 200);
  this->Serve(std::make_unique<StoreCatalog>(
    this->Models.Path, [](const std::filesystem::path&, const std::string&) {}));
  this->Source->SetModelId("");
  EXPECT_NE(this->Refusal().find("name one of other, sphere"), std::string::npos);
  const std::string url = this->Source->GetUrl();
  this->Source->SetModelId("sphere");
  EXPECT_EQ(LoadedPartitions(this->Update()), 128u);
  // The connection is lost, and the server is gone when the source asks again.
  this->Server.reset();
  const std::string lost = this->Refusal();
  EXPECT_NE(lost.find(url + ": "), std::string::npos) << lost;
  this->Source->SetTimeout(59); // needs another connection
  EXPECT_NE(this->Refusal().find("cannot be reached"), std::string::npos);
}

TEST_F(TestKdStreamSource, ADamagedPartitionIsNamed)
{
  auto torus = std::make_unique<TorusCatalog>();
  torus->model->damaged = protocol::BlobId::Partition(2);
  this->Serve(std::move(torus));
  const std::string error = this->Refusal();
  EXPECT_NE(error.find("partitions/2 cannot be loaded"), std::string::npos) << error;
}

TEST_F(TestKdStreamSource, ATokenSaysWhatMayBeHad)
{
  this->Serve(std::make_unique<TorusCatalog>(),
    std::make_shared<TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; }));
  this->Source->SetContentToLevel();
  const std::string none = this->Refusal();
  EXPECT_NE(none.find("the server says 401: this server requires a token"), std::string::npos)
    << none;
  this->Source->SetToken(forged::Token(
    forged::header, R"({"sub":"ann","exp":2000,"models":["torus"],"detail":"levels"})"));
  EXPECT_GT(ContentOf(this->Update()).cells.size(), 1000u);
  this->Source->SetContentToOriginal();
  const std::string original = this->Refusal();
  EXPECT_NE(original.find("the token only allows the levels of torus"), std::string::npos)
    << original;
}

// A model whose blobs do not arrive until it is released.
class SilentModel : public TorusModel
{
public:
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    this->isAsked = true;
    this->gone.wait();
    return TorusModel::ReadBlob(blob);
  }
  ~SilentModel() override = default;
  mutable std::atomic<bool> isAsked{ false };
  std::promise<void> letGo;
  std::shared_future<void> gone = letGo.get_future().share();
};

// Aborts at the first progress report at which isTime() is true, and records when that was.
struct AbortWhen
{
  vtkAlgorithm& filter;
  std::function<bool()> isTime;
  std::chrono::steady_clock::time_point at{};
  void Look(vtkObject*, unsigned long, void*)
  {
    if (!this->filter.GetAbortExecute() && this->isTime())
    {
      this->at = std::chrono::steady_clock::now();
      this->filter.SetAbortExecute(1);
    }
  }
  void Tell(const std::string& what) const
  {
    const std::chrono::duration<double, std::milli> took =
      std::chrono::steady_clock::now() - this->at;
    std::cout << what << ": ended " << took.count() << " ms after the abort\n";
  }
};

// The timeout is longer than this test may take, so the test hangs if an update does not stop.
TEST_F(TestKdStreamSource, EveryOutputStopsWhileNothingComes)
{
  std::shared_ptr<SilentModel> silent;
  this->Source->SetTimeout(3600);
  this->Source->AddPartition(3);
  AbortWhen abort{ *this->Source, [&] { return silent->isAsked.load(); } };
  this->Source->AddObserver(vtkCommand::ProgressEvent, &abort, &AbortWhen::Look);
  for (const int content : { vtkKdModelSource::Original, vtkKdModelSource::Level,
         vtkKdModelSource::Partitions, vtkKdModelSource::Region, vtkKdModelSource::View })
  {
    for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
    {
      auto torus = std::make_unique<TorusCatalog>();
      torus->model = silent = std::make_shared<SilentModel>();
      this->Serve(std::move(torus));
      this->Source->SetContent(content);
      this->Source->SetOutputType(type);
      this->Source->SetBoundsOfPartitions(content == vtkKdModelSource::Original);
      FilterObserver heard(this->Source);
      EXPECT_TRUE(ContentOf(this->Update(), true).points.empty());
      EXPECT_EQ(heard.error, "") << content << type;
      EXPECT_FALSE(heard.failed);
      abort.Tell("content " + std::to_string(content) + ", type " + std::to_string(type));
      silent->letGo.set_value();
    }
  }
  // When the server answers, the next Update has the output, although nothing was set.
  abort.isTime = [] { return false; };
  EXPECT_FALSE(ContentOf(this->Update()).points.empty());
}

// Aborts a source at the nth progress report of at least a given progress; records the maximum
// progress, and the number of reports.
struct StopAt
{
  vtkAlgorithm* source;
  double progress = 2;
  int nth = 1, reached = 0;
  double most = 0;
  int atMost = 0, afterStop = 0;
  void Look(vtkObject*, unsigned long, void* data)
  {
    const double now = *static_cast<double*>(data);
    if (now < 1 && now >= this->most)
    {
      this->atMost = now > this->most ? 1 : this->atMost + 1;
      this->most = now;
    }
    this->afterStop += this->reached >= this->nth ? 1 : 0;
    if (now >= this->progress && ++this->reached == this->nth)
    {
      this->source->SetAbortExecute(1);
    }
  }
  void Start(double from, int times)
  {
    *this = { this->source, from, times };
    this->source->Modified();
  }
};

// VTK itself would forget an abort that comes when the model is open and nothing has been read yet.
TEST_F(TestKdStreamSource, AnAbortBeforeItReadsCounts)
{
  struct AbortAtStart
  {
    void Look(vtkObject* source, unsigned long, void*)
    {
      vtkAlgorithm::SafeDownCast(source)->SetAbortExecute(1);
    }
  } abort;
  const unsigned long observer =
    this->Source->AddObserver(vtkCommand::StartEvent, &abort, &AbortAtStart::Look);
  FilterObserver heard(this->Source);
  EXPECT_TRUE(ContentOf(this->Update(), true).points.empty());
  EXPECT_EQ(heard.error, "");
  this->Source->RemoveObserver(observer);
  EXPECT_FALSE(ContentOf(this->Update()).points.empty());
}

// At any progress report, from the first one to the last, also before the first piece has arrived
// and after the last one: after an abort there are no more reports, and the output is empty.
TEST_F(TestKdStreamSource, EveryOutputStopsAtAnyOfItsSteps)
{
  StopAt stop{ this->Source };
  this->Source->AddObserver(vtkCommand::ProgressEvent, &stop, &StopAt::Look);
  this->Source->SetCameraPosition(0, 0, 2);
  this->Source->AddPartition(3);
  this->Source->AddPartition(100);
  for (const int content : { vtkKdModelSource::Original, vtkKdModelSource::Level,
         vtkKdModelSource::Partitions, vtkKdModelSource::Region, vtkKdModelSource::View })
  {
    for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
    {
      SCOPED_TRACE("content " + std::to_string(content) + ", type " + std::to_string(type));
      this->Source->SetContent(content);
      this->Source->SetOutputType(type);
      stop.Start(2, 1);
      ASSERT_FALSE(ContentOf(this->Update()).points.empty());
      const double most = stop.most;
      const int atMost = stop.atMost;
      std::vector<std::pair<double, int>> when{ { 0.0, 1 }, { 0.0, 2 }, { 0.0, 3 } };
      if (most > 0) // 0: one piece, with any number of reports
      {
        when.insert(when.end(), { { most / 2, 1 }, { most, 1 }, { most, atMost } });
      }
      for (const auto& [progress, nth] : when)
      {
        FilterObserver heard(this->Source);
        stop.Start(progress, nth);
        EXPECT_TRUE(ContentOf(this->Update(), true).points.empty()) << progress << " " << nth;
        EXPECT_LE(stop.afterStop, 2) << "the pipeline tells of its own begin";
        EXPECT_EQ(heard.error, "");
      }
    }
  }
}

TEST_F(TestKdStreamSource, StopsWhileAServerDoesNotAnswer)
{
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(listener, 1), 0);
  ASSERT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  this->Source->SetUrl("http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  int reported = 0;
  AbortWhen abort{ *this->Source, [&] { return ++reported == 3; } };
  this->Source->AddObserver(vtkCommand::ProgressEvent, &abort, &AbortWhen::Look);
  FilterObserver heard(this->Source);
  EXPECT_TRUE(ContentOf(this->Update(), true).points.empty());
  EXPECT_EQ(heard.error, ""); // no error about the timeout
  abort.Tell("a server that does not answer");
  this->Source->RemoveAllObservers();
  ReportedErrors late(*this->Source);
  this->Source->SetTimeout(1); // also limits connecting
  this->Update();
  EXPECT_NE(late.Take().find("the server has sent nothing for 1 s"), std::string::npos);
  EXPECT_EQ(this->Source->GetErrorCode(), vtkErrorCode::CannotOpenFileError);
  ::close(listener);
}

TEST_F(TestKdStreamSource, ProgressGrowsToItsEnd)
{
  for (const int content : { vtkKdModelSource::Original, vtkKdModelSource::View })
  {
    this->Source->SetContent(content);
    this->Source->SetOutputTypeToPolyData();
    FilterObserver heard(this->Source);
    this->Update();
    const auto begin = std::find(heard.progress.rbegin(), heard.progress.rend(), 0.0).base();
    EXPECT_TRUE(std::is_sorted(begin, heard.progress.end()));
    EXPECT_GT(std::set<double>(begin, heard.progress.end()).size(), 3u);
    EXPECT_EQ(heard.progress.back(), 1);
  }
}

TEST_F(TestKdStreamSource, AModelThatWasReplacedIsOpenedAnew)
{
  const Content first = ContentOf(this->Update());
  ASSERT_FALSE(first.cells.empty());
  const Mesh torus = fixtures::Torus(20, 10);
  BuildTo(this->File, torus, 100);
  ASSERT_TRUE(dynamic_cast<StoreCatalog&>(*this->Served).Reload());
  this->Source->Modified();
  const Content second = ContentOf(this->Update());
  EXPECT_EQ(second.cells.size(), torus.triangles.size());
  EXPECT_EQ(this->Source->GetNumberOfModelPoints(), vtkIdType(torus.points.size()));
  // Also if the server was restarted at the same address, so that the connection is lost.
  BuildTo(this->File, this->Sphere, 200);
  const std::uint16_t port = this->Server->Port();
  this->Server.reset();
  ASSERT_TRUE(dynamic_cast<StoreCatalog&>(*this->Served).Reload());
  HttpServerOptions options;
  options.address.port = port;
  options.drainTimeout = std::chrono::milliseconds(100);
  auto server = HttpServer::Start(*this->Served, options);
  ASSERT_TRUE(server) << server.GetError().message;
  this->Server = std::move(*server);
  this->Source->Modified();
  EXPECT_TRUE(ContentOf(this->Update()) == first);
}

// After an error while reading, nothing needs to be set either.
TEST_F(TestKdStreamSource, TheUpdateAfterAFailureOpensAnew)
{
  auto torus = std::make_unique<TorusCatalog>();
  torus->model->damaged = protocol::BlobId::Partition(2);
  TorusModel& model = *torus->model;
  this->Serve(std::move(torus));
  EXPECT_NE(this->Refusal(), "");
  model.damaged.reset();
  EXPECT_FALSE(ContentOf(this->Update()).cells.empty());
}

TEST_F(TestKdStreamSource, StopsWhenCancelled)
{
  FilterObserver heard(this->Source);
  heard.abortAt = 0;
  EXPECT_EQ(LoadedPartitions(this->Update()), 0u);
  EXPECT_EQ(heard.error, "");
  heard.abortAt = 2;
  EXPECT_EQ(LoadedPartitions(this->Update()), 128u);
}

}
