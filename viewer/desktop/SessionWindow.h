// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/PictureDistances.h"
#include "viewer/desktop/PictureLegend.h"
#include "viewer/desktop/RegionBoxes.h"
#include "viewer/desktop/SessionScene.h"
#include "viewer/desktop/SettingSteps.h"
#include "viewer/offscreen/OffscreenWindow.h"

#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

class SessionWindow
{
public:
  // Errors: those of MakeOffscreenWindow.
  static Result<std::unique_ptr<SessionWindow>> MakeOffscreen(
    WindowBackend backend, int width, int height, const SceneSettings& settings);
  // Makes a window on the screen. Errors: those of MakeScreenWindow.
  static Result<std::unique_ptr<SessionWindow>> MakeOnScreen(
    int width, int height, const SceneSettings& settings);

  void Resize(const Viewport& view);
  // Applies from the next picture on.
  void SetSettings(const SceneSettings& settings);
  const SceneSettings& Settings() const { return this->How; }
  // Renders the session's scene, and the overlays that the settings ask for. unit: of the model.
  // The surface is uploaded to graphics memory only if it has changed since the last call.
  Status Show(const ViewerSession& session, const std::string& unit);
  // Writes what was shown last.
  Status SavePicture(const std::string& file);

private:
  SessionWindow(vtkSmartPointer<vtkRenderWindow> window, const SceneSettings& settings);

  vtkSmartPointer<vtkRenderWindow> Window;
  SessionScene Scene;
  RegionBoxes Boxes;
  PictureDistances Distances;
  PictureLegend Legend;
  SceneSettings How;
  double PixelRatio = 1;
};

}
