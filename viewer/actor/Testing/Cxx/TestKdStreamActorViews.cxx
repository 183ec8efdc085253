// SPDX-License-Identifier: BSD-3-Clause
// How a renderer's camera sees surfaces and clouds: with any kind of projection, in tiles, in
// passes for other cameras, in a window without a size. Also destroys the objects in any order.
// Needs an X server.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/adapter/Testing/ReportedErrors.h"
#include "filters/build/Builder.h"

#include <gtest/gtest.h>

#include <vtkAssembly.h>
#include <vtkCamera.h>
#include <vtkCameraPass.h>
#include <vtkCommand.h>
#include <vtkEDLShading.h>
#include <vtkGenericRenderWindowInteractor.h>
#include <vtkImageData.h>
#include <vtkKdStreamActor.h>
#include <vtkLight.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpaquePass.h>
#include <vtkOpenGLRenderer.h>
#include <vtkProp3DCollection.h>
#include <vtkProperty.h>
#include <vtkRenderPassCollection.h>
#include <vtkRenderState.h>
#include <vtkRenderStepsPass.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSequencePass.h>
#include <vtkShadowMapBakerPass.h>
#include <vtkShadowMapPass.h>
#include <vtkSmartPointer.h>
#include <vtkTransform.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;
using fixtures::TemporaryFolder;
using kdstream::testing::ReportedErrors;
using Clock = std::chrono::steady_clock;

constexpr double deadline = 60; // seconds, for what takes a few tenths
const double nan = std::numeric_limits<double>::quiet_NaN();

using Pixels = std::vector<unsigned char>;

// Returns how many of a thousand pixels differ visibly.
int Differing(const Pixels& a, const Pixels& b)
{
  EXPECT_EQ(a.size(), b.size());
  int count = 0;
  for (std::size_t i = 0; i + 2 < std::min(a.size(), b.size()); i += 3)
  {
    const auto differs = [&](std::size_t k) { return std::abs(a[i + k] - b[i + k]) > 40; };
    count += differs(0) || differs(1) || differs(2) ? 1 : 0;
  }
  return static_cast<int>(3000.0 * count / double(a.size()));
}

std::size_t Covered(const Pixels& pixels)
{
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < pixels.size(); i += 3)
  {
    count += pixels[i] + pixels[i + 1] + pixels[i + 2] > 0 ? 1 : 0;
  }
  return count;
}

class TestKdStreamActorViews : public ::testing::Test
{
protected:
  static std::string Store(const char* name, const std::function<Mesh()>& make)
  {
    static const TemporaryFolder folder;
    const std::filesystem::path file = folder / (std::string(name) + ".kds");
    if (!std::filesystem::exists(file))
    {
      BuildOptions options;
      options.tree.verticesPerPartition = 500;
      const auto built = BuildStore(make(), name, file, options);
      EXPECT_TRUE(built) << built.GetError().message;
    }
    return file.string();
  }
  // Bumpy spheres of radius 1 about the origin: of 131,072 triangles, and of 10,242 points.
  static std::string Surface()
  {
    return Store("surface", [] { return fixtures::DisplacedSphere(7); });
  }
  static std::string Cloud()
  {
    return Store("cloud", [] { return fixtures::Cloud(5); });
  }
  void Open(const std::string& source)
  {
    this->Actor->SetSource(source);
    this->Actor->SetNumberOfTriangles(500000); // models must not count as small
    this->Renderer->AddActor(this->Actor);
    this->Window->AddRenderer(this->Renderer);
    this->Window->SetSize(200, 200);
    this->Camera().SetPosition(0, 0, 6);
    this->Camera().SetFocalPoint(0, 0, 0);
    this->Camera().SetViewUp(0, 1, 0);
    this->Camera().SetClippingRange(1, 20);
  }
  vtkCamera& Camera() { return *this->Renderer->GetActiveCamera(); }
  // Returns the picture of the refined model.
  Pixels Picture()
  {
    EXPECT_TRUE(this->Actor->Refine(this->Renderer, deadline));
    this->Window->Render();
    EXPECT_TRUE(this->Actor->IsComplete());
    return this->Shown();
  }
  Pixels Shown()
  {
    const int* const size = this->Window->GetSize();
    vtkNew<vtkUnsignedCharArray> pixels;
    this->Window->GetPixelData(0, 0, size[0] - 1, size[1] - 1, 1, pixels);
    return { pixels->GetPointer(0), pixels->GetPointer(0) + pixels->GetNumberOfValues() };
  }
  // Sets up the camera differently; it must see the same as before.
  void ExpectTheSame(const char* what, const std::function<void()>& setUp)
  {
    SCOPED_TRACE(what);
    const Pixels before = this->Picture();
    const vtkIdType drawn = this->Actor->GetNumberOfDrawnPoints();
    EXPECT_GT(Covered(before), 1000u);
    setUp();
    const Pixels now = this->Picture();
    EXPECT_LE(Differing(before, now), 10);
    EXPECT_NEAR(double(this->Actor->GetNumberOfDrawnPoints()), double(drawn), 0.05 * double(drawn));
  }

  vtkSmartPointer<vtkKdStreamActor> Actor = vtkSmartPointer<vtkKdStreamActor>::New();
  vtkSmartPointer<vtkRenderer> Renderer = vtkSmartPointer<vtkRenderer>::New();
  vtkSmartPointer<vtkRenderWindow> Window = vtkSmartPointer<vtkRenderWindow>::New();
};

// As doc/from-vtk.md does it: without SetSize, and with Refine before the first picture.
TEST_F(TestKdStreamActorViews, AWindowWithoutASizeIsRefinedForTheOneThatItGets)
{
  this->Actor->SetSource(Surface());
  this->Actor->SetNumberOfTriangles(500000);
  this->Renderer->AddActor(this->Actor);
  this->Renderer->SetViewport(0, 0, 1, 0.5);
  this->Window->AddRenderer(this->Renderer);
  this->Renderer->ResetCamera();
  this->Camera().Zoom(3);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  const vtkIdType refined = this->Actor->GetNumberOfDrawnTriangles();
  EXPECT_GT(refined, 8000) << "not the preview";
  this->Window->Render();
  EXPECT_EQ(this->Window->GetSize()[1], 300);
  EXPECT_TRUE(this->Actor->IsComplete());
  EXPECT_EQ(this->Actor->GetNumberOfDrawnTriangles(), refined);
}

TEST_F(TestKdStreamActorViews, RefineNeedsAWindowAndSeconds)
{
  this->Open(Surface());
  ReportedErrors heard(*this->Actor);
  for (const double seconds : { nan, -1.0 })
  {
    EXPECT_FALSE(this->Actor->Refine(this->Renderer, seconds));
    EXPECT_NE(heard.Take().find("Refine needs 0 seconds or more, not "), std::string::npos);
  }
  vtkNew<vtkRenderer> alone;
  EXPECT_FALSE(this->Actor->Refine(alone, 1));
  EXPECT_NE(heard.Take().find("in a window"), std::string::npos);
  EXPECT_FALSE(this->Actor->Refine(nullptr, 1));
  EXPECT_TRUE(this->Actor->Refine(this->Renderer, deadline));
}

// Seen from so far away that perspective and a parallel projection give the same picture.
TEST_F(TestKdStreamActorViews, AParallelProjectionSeesWhatPerspectiveSeesFromAfar)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    SCOPED_TRACE(source);
    this->Open(source);
    this->Camera().ParallelProjectionOff();
    this->Camera().SetPosition(0, 0, 1000);
    this->Camera().SetClippingRange(990, 1010);
    this->Camera().SetViewAngle(2 * std::atan(1.2 / 1000) * 180 / vtkMath::Pi());
    this->ExpectTheSame("parallel",
      [this]
      {
        this->Camera().ParallelProjectionOn();
        this->Camera().SetParallelScale(1.2);
      });
    this->ExpectTheSame("from near",
      [this]
      {
        this->Camera().SetPosition(0, 0, 6);
        this->Camera().SetClippingRange(1, 20);
      });
  }
}

TEST_F(TestKdStreamActorViews, AllThatACameraIsMadeOfIsFollowed)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    SCOPED_TRACE(source);
    this->Open(source);
    this->Window->SetSize(240, 120);
    this->Camera().SetViewAngle(25);
    this->ExpectTheSame("a horizontal angle",
      [this]
      {
        this->Camera().UseHorizontalViewAngleOn();
        this->Camera().SetViewAngle(
          2 * std::atan(2 * std::tan(vtkMath::RadiansFromDegrees(12.5))) * 180 / vtkMath::Pi());
      });
    this->ExpectTheSame("an explicit projection",
      [this]
      {
        vtkNew<vtkMatrix4x4> projection;
        projection->DeepCopy(this->Camera().GetProjectionTransformMatrix(2, -1, 1));
        this->Camera().SetExplicitProjectionTransformMatrix(projection);
        this->Camera().UseExplicitProjectionTransformMatrixOn();
        this->Camera().SetViewAngle(90);
      });
    this->Camera().UseExplicitProjectionTransformMatrixOff();
    this->Camera().UseHorizontalViewAngleOff();
    this->Camera().SetViewAngle(25);
    this->ExpectTheSame("a transform of all of the scene, against one of the actor's",
      [this]
      {
        vtkNew<vtkMatrix4x4> thrice;
        thrice->SetElement(0, 0, 3);
        thrice->SetElement(1, 1, 3);
        thrice->SetElement(2, 2, 3);
        this->Camera().SetModelTransformMatrix(thrice);
        this->Actor->SetScale(1 / 3.0);
      });
    this->Camera().SetModelTransformMatrix(vtkNew<vtkMatrix4x4>());
    this->Actor->SetScale(1);
    this->ExpectTheSame("a transform of the view, against another place",
      [this]
      {
        this->Camera().SetPosition(0, 0, 4);
        vtkNew<vtkTransform> back;
        back->Translate(0, 0, -2);
        this->Camera().SetUserViewTransform(back);
      });
    this->Camera().SetUserViewTransform(nullptr);
  }
}

// A screen in the world that is seen by an eye which is not in front of its middle.
TEST_F(TestKdStreamActorViews, AnOffAxisProjectionIsFollowed)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    SCOPED_TRACE(source);
    this->Open(source);
    this->Camera().UseExplicitProjectionTransformMatrixOff();
    this->Camera().SetUserViewTransform(nullptr);
    // Taken now: VTK 9.3 keeps the view of the eye for a while after UseOffAxisProjectionOff.
    vtkNew<vtkMatrix4x4> plain;
    plain->DeepCopy(this->Camera().GetModelViewTransformMatrix());
    double eye[] = { 1.5, 0.5, 6 };
    this->Camera().SetEyePosition(eye);
    this->Camera().SetEyeSeparation(0);
    this->Camera().SetScreenBottomLeft(-1.2, -1.2, 0);
    this->Camera().SetScreenBottomRight(1.2, -1.2, 0);
    this->Camera().SetScreenTopRight(1.2, 1.2, 0);
    this->Camera().UseOffAxisProjectionOn();
    this->Picture(); // sets the clipping range, of which VTK 9.3 makes the projection, too
    // Compares an off-axis view with one that has the same matrices set explicitly.
    vtkNew<vtkMatrix4x4> projection, view;
    projection->DeepCopy(this->Camera().GetProjectionTransformMatrix(1, -1, 1));
    view->DeepCopy(this->Camera().GetModelViewTransformMatrix());
    ASSERT_GT(std::abs(projection->GetElement(0, 2)), 0.1);
    this->ExpectTheSame("off axis, against its matrices",
      [&]
      {
        this->Camera().UseOffAxisProjectionOff();
        this->Camera().SetExplicitProjectionTransformMatrix(projection);
        this->Camera().UseExplicitProjectionTransformMatrixOn();
        vtkNew<vtkMatrix4x4> of;
        vtkMatrix4x4::Invert(plain, of);
        vtkMatrix4x4::Multiply4x4(view, of, of);
        vtkNew<vtkTransform> more;
        more->SetMatrix(of);
        this->Camera().SetUserViewTransform(more);
      });
  }
}

TEST_F(TestKdStreamActorViews, AScaledModelLooksAsFromNearer)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    for (const double scale : { 0.001, 1000.0 })
    {
      SCOPED_TRACE(source + " times " + std::to_string(scale));
      this->Open(source);
      this->Actor->SetScale(1);
      this->ExpectTheSame("scaled",
        [this, scale]
        {
          this->Actor->SetScale(scale);
          this->Camera().SetPosition(0, 0, 6 * scale);
          this->Camera().SetClippingRange(scale, 20 * scale);
        });
    }
  }
}

TEST_F(TestKdStreamActorViews, WhatIsScaledToNothingIsNotDrawn)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    SCOPED_TRACE(source);
    this->Open(source);
    this->Actor->SetScale(1, 1, 0);
    this->Window->Render();
    EXPECT_EQ(Covered(this->Shown()), 0u);
    this->Actor->SetScale(1);
    EXPECT_GT(Covered(this->Picture()), 1000u);
  }
}

TEST_F(TestKdStreamActorViews, TilesOfAPictureShowTheSameAndAreAsFineAsItsPixelsNeed)
{
  this->Open(Surface());
  this->Actor->SetSecondsPerFrame(0.002);
  this->Camera().Zoom(2);
  std::set<vtkIdType> drawn;
  struct Listener
  {
    vtkKdStreamActor& actor;
    std::set<vtkIdType>& drawn;
    void Hear() { this->drawn.insert(this->actor.GetNumberOfDrawnTriangles()); }
  } listener{ *this->Actor, drawn };
  const unsigned long observer =
    this->Renderer->AddObserver(vtkCommand::EndEvent, &listener, &Listener::Hear);
  vtkNew<vtkWindowToImageFilter> tiles;
  tiles->SetInput(this->Window);
  tiles->SetScale(3);
  tiles->ReadFrontBufferOff();
  int pictures = 0;
  const auto end = Clock::now() + std::chrono::duration<double>(deadline);
  do
  {
    drawn.clear();
    tiles->Modified();
    tiles->Update();
    EXPECT_EQ(drawn.size(), 1u);
    ++pictures;
  } while (!this->Actor->IsComplete() && Clock::now() < end);
  EXPECT_TRUE(this->Actor->IsComplete());
  EXPECT_GT(pictures, 1);
  this->Renderer->RemoveObserver(observer);
  auto* const image = static_cast<unsigned char*>(tiles->GetOutput()->GetScalarPointer());
  const Pixels tiled(image, image + 3 * 600 * 600);
  // The same picture, not in tiles.
  this->Window->SetSize(600, 600);
  const Pixels whole = this->Picture();
  EXPECT_LE(Differing(tiled, whole), 10);
  EXPECT_NEAR(double(*drawn.begin()), double(this->Actor->GetNumberOfDrawnTriangles()),
    0.02 * double(*drawn.begin()));
}

// Draws for the renderer's camera, then for another camera: a shadow pass does so for a light.
class LightPass : public vtkRenderPass
{
public:
  static LightPass* New() { VTK_STANDARD_NEW_BODY(LightPass); }
  vtkTypeMacro(LightPass, vtkRenderPass);
  void Render(const vtkRenderState* state) override
  {
    vtkRenderer* const renderer = state->GetRenderer();
    this->Opaque->Render(state);
    const vtkSmartPointer<vtkCamera> camera = renderer->GetActiveCamera();
    renderer->SetActiveCamera(this->LightCamera);
    this->Opaque->Render(state);
    renderer->SetActiveCamera(camera);
  }
  vtkNew<vtkCamera> LightCamera;

private:
  vtkNew<vtkOpaquePass> Opaque;
};

TEST_F(TestKdStreamActorViews, PassesOfOtherCamerasDoNotRefine)
{
  this->Open(Surface());
  vtkNew<LightPass> lightSource;
  lightSource->LightCamera->SetPosition(1.3, 0, 0);
  vtkNew<vtkCameraPass> pass;
  pass->SetDelegatePass(lightSource);
  vtkOpenGLRenderer::SafeDownCast(this->Renderer)->SetPass(pass);
  ASSERT_TRUE(this->Actor->Refine(this->Renderer, deadline));
  const vtkIdType drawn = this->Actor->GetNumberOfDrawnTriangles();
  this->Window->Render();
  EXPECT_TRUE(this->Actor->IsComplete());
  EXPECT_EQ(this->Actor->GetNumberOfDrawnTriangles(), drawn);
}

// VTK's own passes: for shadows, whose lights look from elsewhere; for depths; for transparency.
TEST_F(TestKdStreamActorViews, VtksPassesDrawTheRefinedModel)
{
  this->Open(Surface());
  this->Camera().Zoom(1.5);
  const std::size_t plain = Covered(this->Picture());
  const vtkIdType drawn = this->Actor->GetNumberOfDrawnTriangles();
  const auto expectTheSame = [&](const char* what)
  {
    SCOPED_TRACE(what);
    this->Window->Render();
    EXPECT_TRUE(this->Actor->IsComplete());
    EXPECT_EQ(this->Actor->GetNumberOfDrawnTriangles(), drawn);
    EXPECT_NEAR(double(Covered(this->Shown())), double(plain), 0.05 * double(plain));
  };
  auto* const renderer = vtkOpenGLRenderer::SafeDownCast(this->Renderer);

  vtkNew<vtkLight> lightSource;
  lightSource->SetPositional(1);
  lightSource->SetPosition(1.5, 1, 4);
  lightSource->SetFocalPoint(0, 0, 0);
  lightSource->SetConeAngle(40);
  this->Renderer->AddLight(lightSource);
  vtkNew<vtkShadowMapPass> shadows;
  vtkNew<vtkRenderPassCollection> both;
  both->AddItem(shadows->GetShadowMapBakerPass());
  both->AddItem(shadows);
  vtkNew<vtkSequencePass> sequence;
  sequence->SetPasses(both);
  vtkNew<vtkCameraPass> camera;
  camera->SetDelegatePass(sequence);
  renderer->SetPass(camera);
  expectTheSame("shadows");
  camera->ReleaseGraphicsResources(this->Window);

  vtkNew<vtkRenderStepsPass> steps;
  vtkNew<vtkEDLShading> depths;
  depths->SetDelegatePass(steps);
  renderer->SetPass(depths);
  expectTheSame("light by depths");
  depths->ReleaseGraphicsResources(this->Window);

  renderer->SetPass(nullptr);
  this->Actor->GetProperty()->SetOpacity(0.5);
  expectTheSame("blended");
}

TEST_F(TestKdStreamActorViews, WithoutLightItHasItsPlainColour)
{
  for (const std::string& source : { Surface(), Cloud() })
  {
    SCOPED_TRACE(source);
    this->Open(source);
    this->Actor->GetProperty()->LightingOn();
    const std::size_t lit = Covered(this->Picture());
    this->Actor->GetProperty()->LightingOff();
    EXPECT_NEAR(double(Covered(this->Picture())), double(lit), 0.02 * double(lit));
    this->Actor->GetProperty()->LightingOn();
    this->Renderer->AutomaticLightCreationOff();
    this->Renderer->RemoveAllLights();
    EXPECT_NEAR(double(Covered(this->Picture())), double(lit), 0.02 * double(lit));
    this->Renderer->AutomaticLightCreationOn();
    EXPECT_NEAR(double(Covered(this->Picture())), double(lit), 0.02 * double(lit));
  }
}

// Any object can be destroyed first, even with a timer and requests pending.
TEST_F(TestKdStreamActorViews, AnyoneMayGoFirst)
{
  struct Timers
  {
    std::vector<int> ids;
    void Make(vtkObject*, unsigned long, void* id) { this->ids.push_back(*static_cast<int*>(id)); }
  };
  for (const std::string who : { "actor", "renderer", "interactor", "removed" })
  {
    SCOPED_TRACE(who);
    this->Actor = vtkSmartPointer<vtkKdStreamActor>::New();
    this->Renderer = vtkSmartPointer<vtkRenderer>::New();
    this->Window = vtkSmartPointer<vtkRenderWindow>::New();
    this->Open(Surface());
    this->Actor->SetSecondsPerFrame(0);
    this->Camera().Zoom(3);
    auto interactor = vtkSmartPointer<vtkGenericRenderWindowInteractor>::New();
    interactor->SetRenderWindow(this->Window);
    Timers timers;
    interactor->AddObserver(vtkCommand::CreateTimerEvent, &timers, &Timers::Make);
    this->Window->Render();
    ASSERT_EQ(timers.ids.size(), 1u);
    ASSERT_FALSE(this->Actor->IsComplete());
    if (who == "actor")
    {
      this->Renderer->RemoveActor(this->Actor);
      this->Actor = nullptr;
    }
    else if (who == "removed")
    {
      this->Renderer->RemoveActor(this->Actor);
    }
    else if (who == "renderer")
    {
      this->Window->RemoveRenderer(this->Renderer);
      this->Renderer = nullptr;
    }
    else
    {
      this->Window->SetInteractor(nullptr);
      interactor = nullptr;
    }
    for (std::size_t fired = 0; interactor && fired < std::min<std::size_t>(timers.ids.size(), 5);
         ++fired)
    {
      int id = timers.ids[fired];
      interactor->InvokeEvent(vtkCommand::TimerEvent, &id);
    }
    this->Window->Render();
    if (who == "interactor")
    {
      EXPECT_GT(Covered(this->Picture()), 1000u);
    }
  }
}

TEST_F(TestKdStreamActorViews, ACopyOpensTheModelItself)
{
  this->Open(Surface());
  this->Actor->SetPosition(0.2, 0, 0);
  this->Actor->GetProperty()->SetColor(1, 0, 0);
  this->Actor->SetTolerance(2);
  const Pixels before = this->Picture();
  const int parts = this->Actor->GetParts()->GetNumberOfItems();
  auto copy = vtkSmartPointer<vtkKdStreamActor>::New();
  copy->ShallowCopy(this->Actor);
  EXPECT_EQ(copy->GetParts()->GetNumberOfItems(), 0);
  EXPECT_EQ(copy->GetSource(), Surface());
  EXPECT_EQ(copy->GetTolerance(), 2);
  EXPECT_EQ(copy->GetPosition()[0], 0.2);
  EXPECT_NE(copy->GetProperty(), this->Actor->GetProperty());
  this->Renderer->RemoveActor(this->Actor);
  std::swap(copy, this->Actor);
  this->Renderer->AddActor(this->Actor);
  EXPECT_LE(Differing(before, this->Picture()), 2);
  EXPECT_EQ(copy->GetParts()->GetNumberOfItems(), parts);
  // From an assembly of another kind, only the position is copied.
  vtkNew<vtkAssembly> other;
  other->AddPart(copy);
  other->SetPosition(1, 2, 3);
  this->Actor->ShallowCopy(other);
  EXPECT_EQ(this->Actor->GetPosition()[2], 3);
  EXPECT_EQ(this->Actor->GetParts()->IsItemPresent(copy), 0);
}

TEST_F(TestKdStreamActorViews, APartOfAnotherAssemblyIsReportedOnce)
{
  this->Open(Surface());
  this->Renderer->RemoveActor(this->Actor);
  ReportedErrors heard(*this->Actor, vtkCommand::WarningEvent);
  vtkNew<vtkAssembly> assembly;
  assembly->AddPart(this->Actor);
  this->Renderer->AddActor(assembly);
  this->Window->Render();
  EXPECT_NE(heard.Take().find("add it to the renderer itself"), std::string::npos);
  assembly->SetPosition(0.1, 0, 0);
  this->Window->Render();
  EXPECT_EQ(heard.Take(), "");
}

}
