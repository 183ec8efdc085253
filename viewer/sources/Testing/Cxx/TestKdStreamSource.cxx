// SPDX-License-Identifier: BSD-3-Clause
// Models of a server as VTK gets them: what a reader of the store has, and only what is asked for.
#include "server/access/Testing/ForgedToken.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"
#include "viewer/client/Testing/TorusCatalog.h"
#include "viewer/sources/Testing/Cxx/ModelSourceTools.h"

#include <vtkCompositeDataPipeline.h>
#include <vtkInformation.h>
#include <vtkInformationObjectBaseKey.h>
#include <vtkKdStoreReader.h>
#include <vtkKdStreamSource.h>
#include <vtkKdTreePartition.h>

#include <fstream>

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
  auto* const told = vtkPartitionedDataSet::SafeDownCast(this->Source->GetOutputInformation(0)->Get(
    vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA()));
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->GetNumberOfPartitions(), 128u);
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
    heard.error.find("partitions/4 cannot be had: it was not seen before"), std::string::npos)
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
    EXPECT_NE(heard.error.find("no Url is set"), std::string::npos) << heard.error;
  }
  this->Source->SetModelId("cube");
  EXPECT_NE(this->Refusal().find("it has no model cube, but sphere"), std::string::npos);
  BuildTo(this->Models / "other.kds", fixtures::Torus(20, 10), 200);
  this->Serve(std::make_unique<StoreCatalog>(
    this->Models.Path, [](const std::filesystem::path&, const std::string&) {}));
  this->Source->SetModelId("");
  EXPECT_NE(this->Refusal().find("one has to be named: other, sphere"), std::string::npos);
  const std::string url = this->Source->GetUrl();
  this->Source->SetModelId("sphere");
  EXPECT_EQ(LoadedPartitions(this->Update()), 128u);
  // The connection is lost, and is asked for what is not there any more.
  this->Server.reset();
  const std::string lost = this->Refusal();
  EXPECT_NE(lost.find(url + ": "), std::string::npos) << lost;
  this->Source->SetTimeout(59); // another connection
  EXPECT_NE(this->Refusal().find("cannot be reached"), std::string::npos);
}

TEST_F(TestKdStreamSource, ADamagedPartitionIsNamed)
{
  auto torus = std::make_unique<TorusCatalog>();
  torus->model->damaged = protocol::BlobId::Partition(2);
  this->Serve(std::move(torus));
  const std::string error = this->Refusal();
  EXPECT_NE(error.find("partitions/2 cannot be had"), std::string::npos) << error;
}

TEST_F(TestKdStreamSource, ATokenSaysWhatMayBeHad)
{
  this->Serve(std::make_unique<TorusCatalog>(),
    std::make_shared<TokenGuard>(forged::Keys(), [] { return std::int64_t{ 1000 }; }));
  this->Source->SetContentToLevel();
  const std::string none = this->Refusal();
  EXPECT_NE(none.find("the server says 401: this server asks for a token"), std::string::npos)
    << none;
  this->Source->SetToken(forged::Token(
    forged::header, R"({"sub":"ann","exp":2000,"models":["torus"],"detail":"levels"})"));
  EXPECT_GT(ContentOf(this->Update()).cells.size(), 1000u);
  this->Source->SetContentToOriginal();
  const std::string original = this->Refusal();
  EXPECT_NE(original.find("the token is for the levels of torus"), std::string::npos) << original;
}

TEST_F(TestKdStreamSource, StopsWhenToldTo)
{
  FilterObserver heard(this->Source);
  heard.abortAt = 0;
  EXPECT_EQ(LoadedPartitions(this->Update()), 0u);
  EXPECT_EQ(heard.error, "");
}

}
