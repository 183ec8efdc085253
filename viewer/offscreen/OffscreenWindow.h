// SPDX-License-Identifier: BSD-3-Clause
// Windows that draw without a screen (doc/design.md#pictures-without-a-screen). Step "render" of
// the pipeline picture.
//
// Windows draw on EGL, on OSMesa or on an X server, even if VTK was built only for X11, such as
// Debian's. An executable that makes such windows must be given to the CMake function
// kdstream_enable_offscreen.
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

// Returns "auto", "egl", "osmesa" or "x11", as on the command line.
const char* NameOf(WindowBackend backend);
// Errors: InvalidArgument for another name.
Result<WindowBackend> ParseWindowBackend(std::string_view name);

// Makes a window of width × height pixels that draws off screen, ready for renderers, with edges
// anti-aliased by 4 samples. Each side has 1 … 8192 pixels; SetSize may change the size at any
// time. Windows of all backends may exist side by side and draw in turn; a change of backend costs
// about 1 ms. A window destroys its context. Threads: all windows of a process must be used from
// one thread. Errors: InvalidArgument for a size; NotFound or Unsupported if the backend cannot
// draw here. The message says what is missing (library, device, configuration, context, display);
// for Auto, what each backend lacks.
Result<vtkSmartPointer<vtkRenderWindow>> MakeOffscreenWindow(
  WindowBackend backend, int width, int height);

}
