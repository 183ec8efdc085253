// SPDX-License-Identifier: BSD-3-Clause
// Chooses the backend of a window: see OffscreenWindow.h and ScreenWindow.h.
#include "viewer/offscreen/OffscreenWindow.h"

#include "viewer/offscreen/BackendWindows.h"
#include "viewer/offscreen/ScreenWindow.h"

#include <array>
#include <string>

namespace kdstream
{
namespace
{

WindowResult MakeWindow(WindowBackend backend, int width, int height)
{
  switch (backend)
  {
    case WindowBackend::Egl:
      return MakeEglWindow(width, height);
    case WindowBackend::OsMesa:
      return MakeOsMesaWindow(width, height);
    case WindowBackend::X11:
      return MakeX11Window(width, height);
    case WindowBackend::Auto:
      break;
  }
  std::string reasons;
  for (const WindowBackend each : { WindowBackend::Egl, WindowBackend::OsMesa, WindowBackend::X11 })
  {
    WindowResult window = MakeWindow(each, width, height);
    if (window)
    {
      return window;
    }
    reasons += (reasons.empty() ? "" : "; ") + window.GetError().message;
  }
  return Error{ ErrorCode::NotFound, "no backend can draw off screen here: " + reasons };
}

Status CheckSides(int width, int height)
{
  for (const int side : { width, height })
  {
    if (side < 1 || side > largestWindowSide)
    {
      return Error{ ErrorCode::InvalidArgument,
        "a window of " + std::to_string(width) + "x" + std::to_string(height) +
          " pixels: sides are 1 to " + std::to_string(largestWindowSide) };
    }
  }
  return {};
}

// Sets the same number of samples for all backends, because their defaults differ.
WindowResult Smoothed(WindowResult window)
{
  if (window)
  {
    (*window)->SetMultiSamples(4);
  }
  return window;
}

constexpr std::array<const char*, 4> backendNames{ "auto", "egl", "osmesa", "x11" };

}

const char* NameOf(WindowBackend backend)
{
  return backendNames[static_cast<std::size_t>(backend)];
}

Result<WindowBackend> ParseWindowBackend(std::string_view name)
{
  for (std::size_t i = 0; i < backendNames.size(); ++i)
  {
    if (name == backendNames[i])
    {
      return static_cast<WindowBackend>(i);
    }
  }
  return Error{ ErrorCode::InvalidArgument,
    std::string(name) + " must be auto, egl, osmesa or x11" };
}

Result<vtkSmartPointer<vtkRenderWindow>> MakeOffscreenWindow(
  WindowBackend backend, int width, int height)
{
  KDSTREAM_TRY(CheckSides(width, height));
  return Smoothed(MakeWindow(backend, width, height));
}

Result<vtkSmartPointer<vtkRenderWindow>> MakeScreenWindow(
  int width, int height, const std::string& title)
{
  KDSTREAM_TRY(CheckSides(width, height));
  return Smoothed(MakeX11ScreenWindow(width, height, title));
}

}
