// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the README's picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/SessionScene.h"
#include "viewer/rendering/OffscreenWindow.h"

#include <memory>
#include <string>

namespace kdstream
{

class SessionWindow
{
public:
  // Errors: those of MakeOffscreenWindow.
  static Result<std::unique_ptr<SessionWindow>> MakeOffscreen(
    WindowBackend backend, int width, int height, const SceneStyle& style);
  // One that is shown on the screen. Errors: those of MakeScreenWindow.
  static Result<std::unique_ptr<SessionWindow>> MakeOnScreen(
    int width, int height, const SceneStyle& style);

  void Resize(int width, int height);
  // Renders the scene. The surface is uploaded to the graphics memory only if it has changed since
  // the last time.
  Status Show(const ViewerScene& scene);
  // Writes what was shown last.
  Status SavePicture(const std::string& file);

private:
  SessionWindow(vtkSmartPointer<vtkRenderWindow> window, const SceneStyle& style);

  vtkSmartPointer<vtkRenderWindow> Window;
  SessionScene Scene;
};

}
