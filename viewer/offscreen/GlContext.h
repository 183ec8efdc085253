// SPDX-License-Identifier: BSD-3-Clause
// An OpenGL context without a window, and which one is current. Internal to viewer/offscreen.
//
// Contexts of EGL, OSMesa and GLX may exist side by side, but the libraries do not know of each
// other. So the current context is released before one of another library is made current;
// otherwise the first library would treat its context as still current.
#pragma once

#include "filters/core/Result.h"
#include "viewer/offscreen/GlLibrary.h"

#include <memory>

namespace kdstream
{

// Threads: one context at a time is current in a thread; a context must be destroyed in the thread
// that used it.
class GlContext
{
public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext();

  // Makes this the current context of this thread. Fast if it already is. Errors: InputOutput if
  // its library refuses; those of UseGlLibrary.
  Status MakeCurrent();
  bool IsCurrent() const;

protected:
  virtual const GlLibrary& Library() const = 0;
  virtual Status Bind() = 0;
  virtual void Unbind() = 0;
  // Whether its library says that it is current.
  virtual bool IsBound() const = 0;

  // Unbinds it if it is current. Derived destructors call this first.
  void LetGo();
};

// A context on EGL without a display server: OpenGL 3.2 core or later, on Mesa's surfaceless
// platform, else on the first device that has one. Everything is drawn into framebuffer objects.
// Errors: NotFound without libEGL, a device or a configuration; Unsupported if there is no such
// OpenGL.
Result<std::unique_ptr<GlContext>> MakeEglContext();

// A context of OSMesa, Mesa's renderer in main memory; otherwise the same. Errors: NotFound without
// libOSMesa; Unsupported if there is no such OpenGL.
Result<std::unique_ptr<GlContext>> MakeOsMesaContext();

}
