// SPDX-License-Identifier: BSD-3-Clause
// Windows that draw without a screen (doc/design.md#pictures-without-a-screen). Step "render" of
// the pipeline picture.
//
// On EGL, on OSMesa or on an X server, also with a VTK that was built only for X11, as Debian's. An
// executable that makes such windows must be given to the CMake function kdstream_enable_offscreen.
#pragma once

#include "filters/core/Result.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <string_view>

namespace kdstream
{

enum class WindowBackend
{
  Auto,   // the first of the following that works
  Egl,    // libEGL without a display server: Mesa's surfaceless platform, or a device
  OsMesa, // libOSMesa: Mesa's renderer in main memory
  X11     // an X server with GLX, named by DISPLAY; nothing is shown there
};

inline constexpr int largestWindowSide = 8192;

// "auto", "egl", "osmesa", "x11": as on the command line.
const char* NameOf(WindowBackend backend);
// Errors: InvalidArgument for another name.
Result<WindowBackend> ParseWindowBackend(std::string_view name);

// Makes a window of width × height pixels that draws off screen, ready for renderers, with edges
// anti-aliased by 4 samples. Sizes are 1 … 8192 a side, and may be changed by SetSize at any time.
// Windows of all backends may live side by side and draw in turn; a change of backend costs about 1
// ms. A window's context ends with it. Threads: all windows of a process must be used from one
// thread. Errors: InvalidArgument for a size; NotFound or Unsupported if the backend cannot draw
// here, saying what is missing (library, device, configuration, context, display); for Auto what
// each backend lacks.
Result<vtkSmartPointer<vtkRenderWindow>> MakeOffscreenWindow(
  WindowBackend backend, int width, int height);

}
