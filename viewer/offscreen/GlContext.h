// SPDX-License-Identifier: BSD-3-Clause
// OpenGL contexts without a window, and which of them is current. Internal to viewer/offscreen.
//
// Contexts of EGL, OSMesa and GLX may exist side by side, but these libraries do not know of each
// other. So the current context is released before a context of another library is made current;
// otherwise its library would still treat it as current.
#pragma once

#include "filters/core/Result.h"
#include "viewer/offscreen/GlLibrary.h"

#include <memory>

namespace kdstream
{

// Threads: only one context at a time is current in a thread. A context must be destroyed in the
// thread that used it.
class GlContext
{
public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext();

  // Makes this the current context of this thread. Fast if it already is. Errors: InputOutput if
  // the context's library refuses; those of UseGlLibrary.
  Status MakeCurrent();
  bool IsCurrent() const;

protected:
  virtual const GlLibrary& Library() const = 0;
  virtual Status Bind() = 0;
  virtual void Unbind() = 0;
  // Whether this context's library reports that it is current.
  virtual bool IsBound() const = 0;

  // Releases this context if it is current. Derived destructors call this first.
  void LetGo();
};

// Makes a context of EGL without a display server: OpenGL 3.2 core or later, on Mesa's surfaceless
// platform or, if there is none, on the first device that works. Everything is drawn into
// framebuffer objects. Errors: NotFound if there is no libEGL, device or configuration; Unsupported
// if this OpenGL is not available.
Result<std::unique_ptr<GlContext>> MakeEglContext();

// Makes a context of OSMesa, Mesa's renderer in main memory; otherwise as above. Errors: NotFound
// if there is no libOSMesa; Unsupported if this OpenGL is not available.
Result<std::unique_ptr<GlContext>> MakeOsMesaContext();

}
