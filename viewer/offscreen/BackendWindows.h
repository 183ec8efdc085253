// SPDX-License-Identifier: BSD-3-Clause
// One maker of windows for each backend. Internal to viewer/offscreen; OffscreenWindow.h is for
// everybody.
//
// There are two sets of definitions, and CMake takes one: GlxOnlyWindows.cxx for a VTK that knows
// GLX windows only, such as Debian's 9.1, and OwnWindows.cxx for a VTK that has windows for EGL or
// OSMesa itself.
#pragma once

#include "filters/core/Result.h"

#include <vtkRenderWindow.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <string>

struct _XDisplay; // NOLINT(bugprone-reserved-identifier): the name that X11 gives it

namespace kdstream
{

using WindowResult = Result<vtkSmartPointer<vtkRenderWindow>>;

// Each: a window that draws off screen, of `width` × `height` pixels, with its context made and
// checked.
WindowResult MakeEglWindow(int width, int height);
WindowResult MakeOsMesaWindow(int width, int height);
WindowResult MakeX11Window(int width, int height);
// One that is shown on the screen, ready for VTK's interactor.
WindowResult MakeX11ScreenWindow(int width, int height, const std::string& title);

// A connection to the X server, which ends with it.
struct X11Disconnect
{
  void operator()(_XDisplay* display) const;
};
using X11Connection = std::unique_ptr<_XDisplay, X11Disconnect>;

// Asks whether the display that DISPLAY names is there and has GLX: VTK ends the program if not. To
// be held until VTK has a connection of its own, since some servers start anew when their last
// client goes. Errors: NotFound.
Result<X11Connection> ConnectToX11();

}
