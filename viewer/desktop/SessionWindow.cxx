// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the pipeline picture.
#include "viewer/desktop/SessionWindow.h"

#include "viewer/offscreen/ScreenWindow.h"
#include "viewer/rendering/Picture.h"
#include "viewer/session/ViewerSession.h"

#include <vtkRenderer.h>

#include <utility>

namespace kdstream
{

Result<std::unique_ptr<SessionWindow>> SessionWindow::MakeOffscreen(
  WindowBackend backend, int width, int height, const SceneSettings& settings)
{
  auto window = MakeOffscreenWindow(backend, width, height);
  KDSTREAM_TRY(window);
  return std::unique_ptr<SessionWindow>(new SessionWindow(std::move(*window), settings));
}

Result<std::unique_ptr<SessionWindow>> SessionWindow::MakeOnScreen(
  int width, int height, const SceneSettings& settings)
{
  auto window = MakeScreenWindow(width, height, "KdStream");
  KDSTREAM_TRY(window);
  return std::unique_ptr<SessionWindow>(new SessionWindow(std::move(*window), settings));
}

SessionWindow::SessionWindow(vtkSmartPointer<vtkRenderWindow> window, const SceneSettings& settings)
  : Window(std::move(window))
  , Boxes(this->Scene.Renderer())
  , Distances(this->Scene.Renderer())
  , Legend(this->Scene.Renderer())
{
  this->SetSettings(settings);
  this->Window->AddRenderer(&this->Scene.Renderer());
  this->Window->AddRenderer(&this->Boxes.Renderer());
  this->Distances.AddTo(*this->Window);
  this->Legend.AddTo(*this->Window);
}

void SessionWindow::Resize(const Viewport& view)
{
  this->Window->SetSize(view.width, view.height);
  this->PixelRatio = view.pixelRatio;
}

void SessionWindow::SetSettings(const SceneSettings& settings)
{
  this->How = settings;
  this->Scene.SetAppearance(settings.colors, settings.occlusion);
}

Status SessionWindow::Show(const ViewerSession& session, const std::string& unit)
{
  const ViewerScene scene = session.Scene();
  KDSTREAM_TRY(this->Scene.Follow(scene));
  this->Boxes.Show(this->How.boxes ? session.RegionBoxes() : std::vector<Box>(),
    this->Scene.Center(), boxLineWidth * this->PixelRatio);
  this->Distances.Show(
    this->How.distances ? SeenMeasurementsOf(session) : std::vector<SeenMeasurement>(), unit,
    this->PixelRatio);
  const Coloring coloring = ColoringOf(this->How.colors, scene.scalars);
  this->Legend.Show(coloring.attribute,
    this->How.legend ? LegendOf(coloring, scene.scalars) : ColorLegend(), this->PixelRatio);
  this->Window->Render();
  this->Window->WaitForCompletion();
  return {};
}

Status SessionWindow::SavePicture(const std::string& file)
{
  return WritePng(*this->Window, file);
}

}
