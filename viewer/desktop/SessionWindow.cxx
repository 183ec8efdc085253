// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the README's picture.
#include "viewer/desktop/SessionWindow.h"

#include "viewer/rendering/Picture.h"
#include "viewer/rendering/ScreenWindow.h"

#include <vtkRenderer.h>

#include <utility>

namespace kdstream
{

Result<std::unique_ptr<SessionWindow>> SessionWindow::MakeOffscreen(
  WindowBackend backend, int width, int height, const SceneStyle& style)
{
  auto window = MakeOffscreenWindow(backend, width, height);
  KDSTREAM_TRY(window);
  return std::unique_ptr<SessionWindow>(new SessionWindow(std::move(*window), style));
}

Result<std::unique_ptr<SessionWindow>> SessionWindow::MakeOnScreen(
  int width, int height, const SceneStyle& style)
{
  auto window = MakeScreenWindow(width, height, "KdStream");
  KDSTREAM_TRY(window);
  return std::unique_ptr<SessionWindow>(new SessionWindow(std::move(*window), style));
}

SessionWindow::SessionWindow(vtkSmartPointer<vtkRenderWindow> window, const SceneStyle& style)
  : Window(std::move(window))
{
  this->Scene.SetStyle(style);
  this->Window->AddRenderer(&this->Scene.Renderer());
}

void SessionWindow::Resize(int width, int height)
{
  this->Window->SetSize(width, height);
}

Status SessionWindow::Show(const ViewerScene& scene)
{
  KDSTREAM_TRY(this->Scene.Follow(scene));
  this->Window->Render();
  this->Window->WaitForCompletion();
  return {};
}

Status SessionWindow::SavePicture(const std::string& file)
{
  return WritePng(*this->Window, file);
}

}
