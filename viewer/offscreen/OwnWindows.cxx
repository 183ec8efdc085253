// SPDX-License-Identifier: BSD-3-Clause
// Windows for a VTK that has windows of its own for EGL or OSMesa: a VTK built with
// VTK_OPENGL_HAS_EGL or VTK_OPENGL_HAS_OSMESA, or VTK 9.4 and later, which opens these libraries
// when it runs. This file only chooses between VTK's windows.
#include "viewer/offscreen/BackendWindows.h"

#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderingOpenGLConfigure.h>

#include <string>

#if __has_include(<vtkEGLRenderWindow.h>)
#define KDSTREAM_VTK_HAS_EGL
#include <vtkEGLRenderWindow.h>
#endif
#if __has_include(<vtkOSOpenGLRenderWindow.h>)
#define KDSTREAM_VTK_HAS_OSMESA
#include <vtkOSOpenGLRenderWindow.h>
#endif
#if defined(VTK_USE_X)
#include <vtkXOpenGLRenderWindow.h>
#undef Status
#endif

namespace kdstream
{
namespace
{

template <class Window>
[[maybe_unused]] WindowResult Make(const char* backend, int width, int height)
{
  const vtkNew<Window> window;
  window->SetOffScreenRendering(1);
  window->SetSize(width, height);
  if (!window->SupportsOpenGL())
  {
    return Error{ ErrorCode::NotFound,
      std::string(backend) + ": VTK finds no OpenGL 3.2: " + window->GetOpenGLSupportMessage() };
  }
  return vtkSmartPointer<vtkRenderWindow>(window);
}

[[maybe_unused]] Error NotBuilt(const char* backend)
{
  return Error{ ErrorCode::Unsupported,
    std::string(backend) + ": this program's VTK was built without it" };
}

}

WindowResult MakeEglWindow([[maybe_unused]] int width, [[maybe_unused]] int height)
{
#if defined(KDSTREAM_VTK_HAS_EGL)
  return Make<vtkEGLRenderWindow>("EGL", width, height);
#else
  return NotBuilt("EGL");
#endif
}

WindowResult MakeOsMesaWindow([[maybe_unused]] int width, [[maybe_unused]] int height)
{
#if defined(KDSTREAM_VTK_HAS_OSMESA)
  return Make<vtkOSOpenGLRenderWindow>("OSMesa", width, height);
#else
  return NotBuilt("OSMesa");
#endif
}

WindowResult MakeX11Window([[maybe_unused]] int width, [[maybe_unused]] int height)
{
#if defined(VTK_USE_X)
  const Result<X11Connection> connection = ConnectToX11();
  KDSTREAM_TRY(connection);
  return Make<vtkXOpenGLRenderWindow>("X11", width, height);
#else
  return NotBuilt("X11");
#endif
}

WindowResult MakeX11ScreenWindow([[maybe_unused]] int width, [[maybe_unused]] int height,
  [[maybe_unused]] const std::string& title)
{
#if defined(VTK_USE_X)
  const Result<X11Connection> connection = ConnectToX11();
  KDSTREAM_TRY(connection);
  const vtkNew<vtkXOpenGLRenderWindow> window;
  window->SetSize(width, height);
  window->SetWindowName(title.c_str());
  window->Initialize();
  return vtkSmartPointer<vtkRenderWindow>(window);
#else
  return NotBuilt("X11");
#endif
}

}
