// SPDX-License-Identifier: BSD-3-Clause
// A model of a server or a store, as an actor in a plain render window: bounds, budgets, idle time,
// picking, pictures. Needs an X server.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/adapter/Testing/ReportedErrors.h"
#include "filters/build/Builder.h"
#include "filters/codec/TextureTile.h"
#include "filters/texture/WritePicture.h"
#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include <gtest/gtest.h>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellPicker.h>
#include <vtkErrorCode.h>
#include <vtkGenericRenderWindowInteractor.h>
#include <vtkImageData.h>
#include <vtkKdStreamActor.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProp3DCollection.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using fixtures::TemporaryFolder;

constexpr int side = 200;
constexpr double deadline = 60; // seconds, for what takes a few hundredths

// Gives every partition a picture of 9 x 5 red texels.
class RedTextures : public PieceTextures
{
public:
  static constexpr std::uint32_t width = 9, height = 5;

  TextureDescription Describe() const override { return { "png" }; }
  Result<EncodedTexture> Make(Piece& piece) const override
  {
    Picture picture{ width, height, 3, {} };
    for (std::uint32_t i = 0; i < width * height; ++i)
    {
      picture.texels.insert(picture.texels.end(), { 255, 0, 0 });
    }
    const TextureTile tile{ width, height, TileImage::Png, EncodePicture(picture, PictureType::Png),
      std::vector<std::array<TileCoordinate, 3>>(
        piece.triangles.size(), { { { 1, 1 }, { 8, 1 }, { 1, 4 } } }) };
    return EncodedTexture{ EncodeTextureTile(tile, piece.triangles), width * height };
  }
};

// A window with an actor, and the store of a bumpy sphere of 32,768 triangles.
class TestKdStreamActor : public ::testing::Test
{
protected:
  static const std::filesystem::path& Store()
  {
    static const TemporaryFolder folder;
    static const std::filesystem::path file = folder / "sphere.kds";
    if (!std::filesystem::exists(file))
    {
      BuildOptions options;
      options.tree.verticesPerPartition = 500;
      const auto built = BuildStore(fixtures::DisplacedSphere(6), "sphere", file, options);
      EXPECT_TRUE(built) << built.GetError().message;
    }
    return file;
  }
  void SetUp() override
  {
    this->Actor->SetSource(Store().string());
    this->Renderer->AddActor(this->Actor);
    this->Window->SetSize(side, side);
    this->Window->AddRenderer(this->Renderer);
  }
  // The number of pixels that show the model, and not the background.
  std::size_t Covered()
  {
    return this->Count([](const unsigned char* c) { return c[0] + c[1] + c[2] > 0; });
  }
  template <class Is>
  std::size_t Count(const Is& is)
  {
    vtkNew<vtkUnsignedCharArray> pixels;
    this->Window->GetPixelData(0, 0, side - 1, side - 1, 1, pixels);
    std::size_t count = 0;
    for (vtkIdType i = 0; i < pixels->GetNumberOfTuples(); ++i)
    {
      count += is(pixels->GetPointer(3 * i)) ? 1 : 0;
    }
    return count;
  }

  vtkNew<vtkKdStreamActor> Actor;
  vtkNew<vtkRenderer> Renderer;
  vtkNew<vtkRenderWindow> Window;
};

TEST_F(TestKdStreamActor, TheFirstPictureHasThePreviewAndMoreComesByFrames)
{
  this->Actor->SetSecondsPerFrame(0); // only one piece per picture
  this->Window->Render();
  const vtkIdType preview = this->Actor->GetNumberOfDrawnTriangles();
  EXPECT_GT(preview, 1000);
  EXPECT_LT(preview, 10000);
  EXPECT_GT(this->Covered(), std::size_t(side * side / 5));
  vtkIdType drawn = preview;
  int grew = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(deadline);
  while (!this->Actor->IsComplete() && std::chrono::steady_clock::now() < end)
  {
    this->Window->Render();
    grew += this->Actor->GetNumberOfDrawnTriangles() > drawn ? 1 : 0;
    drawn = this->Actor->GetNumberOfDrawnTriangles();
  }
  EXPECT_TRUE(this->Actor->IsComplete());
  EXPECT_GT(grew, 1) << "it comes bit by bit";
  EXPECT_GT(drawn, 2 * preview);
  EXPECT_GT(this->Actor->GetNumberOfReceivedBytes(), 100000u);
}

TEST_F(TestKdStreamActor, RefinesByTheViewWithinItsBudget)
{
  this->Actor->SetTolerance(0.1);
  this->Actor->SetNumberOfTriangles(10000);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  EXPECT_TRUE(this->Actor->IsComplete());
  const vtkIdType whole = this->Actor->GetNumberOfDrawnTriangles();
  EXPECT_GT(whole, 5000);
  EXPECT_LT(whole, 12000);
  this->Actor->SetNumberOfTriangles(2000000);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  EXPECT_GT(double(this->Actor->GetNumberOfDrawnTriangles()), 1.5 * double(whole));
  // A distant model needs few triangles.
  this->Renderer->GetActiveCamera()->Dolly(0.02);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  EXPECT_LT(this->Actor->GetNumberOfDrawnTriangles(), whole);
  // A parallel projection is followed, too.
  this->Renderer->GetActiveCamera()->ParallelProjectionOn();
  this->Renderer->GetActiveCamera()->SetParallelScale(1.5);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  EXPECT_GT(double(this->Actor->GetNumberOfDrawnTriangles()), 1.5 * double(whole));
}

// Pictures are drawn without a call of Render: the test fires each timer that the interactor makes.
TEST_F(TestKdStreamActor, IdleTimeRefinesUntilAllIsThere)
{
  vtkNew<vtkGenericRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(this->Window);
  struct Clock
  {
    std::vector<int> ids;
    void Make(vtkObject*, unsigned long, void* id) { this->ids.push_back(*static_cast<int*>(id)); }
  } clock;
  interactor->AddObserver(vtkCommand::CreateTimerEvent, &clock, &Clock::Make);
  this->Actor->SetNumberOfTriangles(30000); // not a small model, shown as the original
  this->Actor->SetTolerance(0.3);
  this->Actor->SetSecondsPerFrame(0);
  this->Renderer->ResetCamera();
  this->Renderer->GetActiveCamera()->Dolly(0.6);
  this->Window->Render();
  const vtkIdType first = this->Actor->GetNumberOfDrawnTriangles();
  ASSERT_TRUE(this->Actor->IsComplete()) << "the preview is all that so far away is needed";
  EXPECT_EQ(clock.ids.size(), 0u);
  this->Renderer->GetActiveCamera()->Dolly(3);
  this->Window->Render();
  ASSERT_EQ(clock.ids.size(), 1u);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(deadline);
  for (std::size_t fired = 0; fired < clock.ids.size() && std::chrono::steady_clock::now() < end;
       ++fired)
  {
    int id = clock.ids[fired];
    interactor->InvokeEvent(vtkCommand::TimerEvent, &id);
  }
  EXPECT_TRUE(this->Actor->IsComplete()) << "and no timer is left";
  EXPECT_GT(this->Actor->GetNumberOfDrawnTriangles(), first);
  const std::size_t timers = clock.ids.size();
  this->Window->Render();
  EXPECT_EQ(clock.ids.size(), timers);
}

// The same, in the loop of the interactor that VTK makes for a window.
TEST_F(TestKdStreamActor, APlainInteractorsLoopRefinesUntilAllIsThere)
{
  struct Watch
  {
    vtkKdStreamActor& actor;
    vtkRenderWindowInteractor& interactor;
    std::chrono::steady_clock::time_point end;
    int timers = 0;
    void OnTimer() // also called by the guard's timer below
    {
      ++this->timers;
      if (this->actor.IsComplete() || std::chrono::steady_clock::now() > this->end)
      {
        this->interactor.TerminateApp();
      }
    }
  };
  const auto interactor = vtkSmartPointer<vtkRenderWindowInteractor>::New();
  ASSERT_STRNE(interactor->GetClassName(), "vtkGenericRenderWindowInteractor");
  interactor->SetRenderWindow(this->Window);
  this->Actor->SetSecondsPerFrame(0);
  this->Window->Render();
  const vtkIdType preview = this->Actor->GetNumberOfDrawnTriangles();
  ASSERT_FALSE(this->Actor->IsComplete());
  interactor->Initialize();
  interactor->CreateRepeatingTimer(500); // guard: ends the loop, whatever the actor does
  Watch watch{ *this->Actor, *interactor,
    std::chrono::steady_clock::now() + std::chrono::seconds(int(deadline)) };
  interactor->AddObserver(vtkCommand::TimerEvent, &watch, &Watch::OnTimer);
  interactor->Start();
  EXPECT_TRUE(this->Actor->IsComplete());
  EXPECT_GT(this->Actor->GetNumberOfDrawnTriangles(), 2 * preview);
  EXPECT_GT(watch.timers, 2);
}

TEST_F(TestKdStreamActor, BoundsAreThoseOfTheWholeModelWhereverItIs)
{
  double bounds[6];
  this->Actor->GetBounds(bounds);
  for (int k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(bounds[2 * k], -1, 0.2);
    EXPECT_NEAR(bounds[2 * k + 1], 1, 0.2);
  }
  this->Actor->SetPosition(10, 20, 30);
  this->Actor->SetScale(2);
  double moved[6];
  this->Actor->GetBounds(moved);
  for (int k = 0; k < 6; ++k)
  {
    EXPECT_NEAR(moved[k], 2 * bounds[k] + 10 * (k / 2 + 1), 1e-9);
  }
  this->Window->Render();
  EXPECT_GT(this->Covered(), std::size_t(side * side / 5));
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  vtkNew<vtkCellPicker> picker;
  ASSERT_EQ(picker->Pick(side / 2, side / 2, 0, this->Renderer), 1);
  const double* const hit = picker->GetPickPosition();
  const double r =
    std::sqrt(std::pow(hit[0] - 10, 2) + std::pow(hit[1] - 20, 2) + std::pow(hit[2] - 30, 2));
  EXPECT_NEAR(r, 2, 0.4);
  EXPECT_EQ(picker->GetAssembly(), this->Actor.Get());
}

TEST_F(TestKdStreamActor, AServersModelLooksAsTheStore)
{
  TorusCatalog torus;
  HttpServerOptions options;
  options.drainTimeout = std::chrono::milliseconds(100);
  auto server = HttpServer::Start(torus, options);
  ASSERT_TRUE(server) << server.GetError().message;
  this->Actor->SetSource("http://127.0.0.1:" + std::to_string((*server)->Port()));
  this->Window->Render();
  EXPECT_EQ(this->Actor->GetErrorMessage(), "");
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  EXPECT_GT(this->Covered(), 1000u);
  EXPECT_GT(this->Actor->GetNumberOfDrawnTriangles(), 5000);
}

TEST_F(TestKdStreamActor, PropertyAndColoursAreFollowed)
{
  const auto isRed = [](const unsigned char* c) { return c[0] > 60 && c[1] < 20 && c[2] < 20; };
  this->Actor->GetProperty()->SetColor(1, 0, 0);
  this->Window->Render();
  EXPECT_GT(this->Count(isRed), std::size_t(side * side / 5));
  this->Actor->SetColorBy("partition");
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  EXPECT_LT(this->Count(isRed), std::size_t(side * side / 10));
  const std::size_t opaque = this->Covered();
  this->Actor->GetProperty()->SetOpacity(0.0);
  this->Window->Render();
  EXPECT_LT(this->Covered(), opaque / 10);
}

TEST_F(TestKdStreamActor, PicturesOfATexturedModelAreOnItsParts)
{
  const TemporaryFolder folder;
  BuildOptions options;
  options.tree.verticesPerPartition = 500;
  options.textures = std::make_shared<RedTextures>();
  const auto built = BuildStore(fixtures::DisplacedSphere(6), "red", folder / "red.kds", options);
  ASSERT_TRUE(built) << built.GetError().message;
  this->Actor->SetSource((folder / "red.kds").string());
  this->Renderer->ResetCamera();
  this->Renderer->GetActiveCamera()->Zoom(3);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  const auto texturedParts = [this]
  {
    int count = 0;
    vtkProp3DCollection* const parts = this->Actor->GetParts();
    for (int i = 0; i < parts->GetNumberOfItems(); ++i)
    {
      auto* const part = vtkActor::SafeDownCast(parts->GetItemAsObject(i));
      if (!part || !part->GetTexture())
      {
        continue;
      }
      ++count;
      vtkImageData* const image = part->GetTexture()->GetInput();
      EXPECT_EQ(image->GetDimensions()[0], int(RedTextures::width));
      EXPECT_EQ(image->GetDimensions()[1], int(RedTextures::height));
      EXPECT_EQ(image->GetScalarComponentAsDouble(4, 2, 0, 0), 255);
      EXPECT_EQ(image->GetScalarComponentAsDouble(4, 2, 0, 1), 0);
      auto* const mesh = vtkPolyData::SafeDownCast(part->GetMapper()->GetInputDataObject(0, 0));
      EXPECT_TRUE(mesh && mesh->GetPointData()->GetTCoords());
    }
    return count;
  };
  const auto isRed = [](const unsigned char* c) { return c[0] > 60 && c[1] < 20 && c[2] < 20; };
  EXPECT_GT(texturedParts(), 4);
  EXPECT_GT(this->Count(isRed), std::size_t(side * side * 3 / 4));
  this->Actor->SetColorBy("none");
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  this->Window->Render();
  EXPECT_EQ(texturedParts(), 0);
  EXPECT_EQ(this->Count(isRed), 0u);
}

TEST_F(TestKdStreamActor, InvalidNumbersAreRefused)
{
  ReportedErrors heard(*this->Actor);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  this->Actor->SetTolerance(nan);
  EXPECT_NE(heard.Take().find("Tolerance must be from 0.01 to 100, not nan: it stays 1"),
    std::string::npos);
  this->Actor->SetSecondsPerFrame(nan);
  EXPECT_NE(heard.Take().find("SecondsPerFrame must be from 0 to 10, not nan"), std::string::npos);
  this->Actor->SetNumberOfTriangles(-1);
  EXPECT_NE(heard.Take().find("NumberOfTriangles must be from 1000 to "), std::string::npos);
  this->Actor->SetTimeout(-1);
  EXPECT_NE(heard.Take().find("Timeout must be from 1 to 3600, not -1"), std::string::npos);
  EXPECT_EQ(this->Actor->GetTolerance(), 1);
  EXPECT_EQ(this->Actor->GetSecondsPerFrame(), 0.02);
  EXPECT_EQ(this->Actor->GetNumberOfTriangles(), 2000000);
  EXPECT_EQ(this->Actor->GetTimeout(), 60);
  this->Actor->SetMemoryLimit(1);
  this->Actor->SetTolerance(1000);
  EXPECT_EQ(heard.Take(), "");
  EXPECT_EQ(this->Actor->GetMemoryLimit(), vtkTypeUInt64{ 16 } << 20);
  EXPECT_EQ(this->Actor->GetTolerance(), 100);
}

TEST_F(TestKdStreamActor, ErrorsAreReportedOnceAndOpenTriesAnew)
{
  ReportedErrors heard(*this->Actor);
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "later.kds";
  this->Actor->SetSource(file.string());
  EXPECT_EQ(this->Actor->GetBounds(), nullptr);
  EXPECT_NE(heard.Take(), "");
  EXPECT_NE(this->Actor->GetErrorMessage().find("later.kds"), std::string::npos);
  EXPECT_EQ(this->Actor->GetErrorCode(), vtkErrorCode::FileNotFoundError);
  this->Window->Render();
  EXPECT_EQ(heard.Take(), "");
  EXPECT_EQ(this->Covered(), 0u);
  std::filesystem::copy(Store(), file);
  EXPECT_TRUE(this->Actor->Open());
  EXPECT_EQ(this->Actor->GetErrorMessage(), "");
  EXPECT_EQ(this->Actor->GetErrorCode(), vtkErrorCode::NoError);
  this->Renderer->ResetCamera();
  this->Window->Render();
  EXPECT_GT(this->Covered(), 1000u);
  this->Actor->SetModelId("cube");
  EXPECT_FALSE(this->Actor->Open());
  EXPECT_NE(heard.Take().find("there is no model cube; there are later"), std::string::npos);
  this->Actor->SetSource("");
  EXPECT_FALSE(this->Actor->Open());
  EXPECT_EQ(this->Actor->GetErrorCode(), vtkErrorCode::NoFileNameError);
}

}
