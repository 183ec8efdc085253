// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the README's picture.
#include "viewer/desktop/SessionWindow.h"

#include "viewer/rendering/Picture.h"

#include <vtkRenderer.h>

namespace kdstream
{

Result<std::unique_ptr<SessionWindow>> SessionWindow::MakeOffscreen(
  WindowBackend backend, int width, int height, const SceneStyle& style)
{
  auto window = MakeOffscreenWindow(backend, width, height);
  KDSTREAM_TRY(window);
  std::unique_ptr<SessionWindow> made(new SessionWindow);
  made->Window = *window;
  made->Scene = std::make_unique<SurfaceScene>();
  made->Scene->SetStyle(style);
  made->Window->AddRenderer(&made->Scene->Renderer());
  return made;
}

Status SessionWindow::Show(const ViewerScene& scene)
{
  if (this->ShownVersion != scene.surfaceVersion)
  {
    const Vec3 centre = scene.box.Empty() ? Vec3{} : scene.box.lo * 0.5 + scene.box.hi * 0.5;
    KDSTREAM_TRY(this->Scene->Update(*scene.surface, scene.depths, centre));
    this->ShownVersion = scene.surfaceVersion;
  }
  KDSTREAM_TRY(this->Scene->SetCamera({ scene.eye, scene.focal, scene.up, scene.viewAngle }));
  this->Window->Render();
  this->Window->WaitForCompletion();
  return {};
}

Status SessionWindow::SavePicture(const std::string& file)
{
  return WritePng(*this->Window, file);
}

}
