// SPDX-License-Identifier: BSD-3-Clause
// A window that shows what a session says. Step "render" of the README's picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/rendering/OffscreenWindow.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionTypes.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace kdstream
{

class SessionWindow
{
public:
  // Errors: those of MakeOffscreenWindow.
  static Result<std::unique_ptr<SessionWindow>> MakeOffscreen(
    WindowBackend backend, int width, int height, const SceneStyle& style);

  // Renders the scene. The surface is uploaded to the graphics memory only if it has changed since
  // the last time.
  Status Show(const ViewerScene& scene);
  // Writes what was shown last.
  Status SavePicture(const std::string& file);

private:
  SessionWindow() = default;

  vtkSmartPointer<vtkRenderWindow> Window;
  std::unique_ptr<SurfaceScene> Scene;
  std::optional<std::uint64_t> ShownVersion;
};

}
