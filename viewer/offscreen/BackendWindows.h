// SPDX-License-Identifier: BSD-3-Clause
// One function per backend, which makes its windows. Internal to viewer/offscreen;
// OffscreenWindow.h is public.
//
// There are two sets of definitions, and CMake compiles one of them: GlxOnlyWindows.cxx for a VTK
// that has only GLX windows, such as Debian's 9.1, and OwnWindows.cxx for a VTK that has windows of
// its own for EGL or OSMesa.
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

// Each function returns a window of `width` × `height` pixels that draws off screen. Its context
// has been made and checked.
WindowResult MakeEglWindow(int width, int height);
WindowResult MakeOsMesaWindow(int width, int height);
WindowResult MakeX11Window(int width, int height);
// Makes a window on the screen, ready for VTK's interactor.
WindowResult MakeX11ScreenWindow(int width, int height, const std::string& title);

// A connection to the X server. It is closed when the object is destroyed.
struct X11Disconnect
{
  void operator()(_XDisplay* display) const;
};
using X11Connection = std::unique_ptr<_XDisplay, X11Disconnect>;

// Checks that the display named in DISPLAY exists and has GLX: without it, VTK would end the
// program. Keep the result until VTK has a connection of its own, because some servers restart when
// their last client disconnects. Errors: NotFound.
Result<X11Connection> ConnectToX11();

}
