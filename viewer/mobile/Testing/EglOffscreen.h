// SPDX-License-Identifier: BSD-3-Clause
// Pictures by OpenGL ES 3 without a screen: a context on EGL's surfaceless platform, and a
// framebuffer to draw into. Step "render" of the pipeline picture. Native only.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace kdstream
{

// Several may exist side by side; MakeCurrent decides which one is drawn into. Threads: one at a
// time.
class EglOffscreen
{
public:
  // Makes a context and makes it current. It has a framebuffer of width × height pixels (1 … the
  // driver's limit, which is at least 2,048) with 8 bits per colour, 24 of depth, 4 samples per
  // pixel. Errors: NotFound if EGL has no surfaceless platform or no driver works; Unsupported if
  // there is no OpenGL ES 3.0, or not with this size; InvalidArgument for a side below 1.
  static Result<std::unique_ptr<EglOffscreen>> Make(int width, int height);
  // REQUIRES: everything that was made in the context has been destroyed.
  ~EglOffscreen();
  EglOffscreen(const EglOffscreen&) = delete;
  EglOffscreen& operator=(const EglOffscreen&) = delete;

  // Makes the context current and binds the framebuffer.
  Status MakeCurrent();

  // The picture: red, green, blue of each pixel, row by row, the top row first; 3 × width × height
  // bytes. REQUIRES: this context is current. Errors: InputOutput if OpenGL returns no pixels.
  Result<std::vector<std::uint8_t>> Pixels();

private:
  EglOffscreen(int width, int height);
  Status MakeContext();
  Status MakeFramebuffers();

  int Width;
  int Height;
  void* Display = nullptr; // EGLDisplay; owned by EGL, shared by all, never closed
  void* Context = nullptr; // EGLContext
  // Drawn has 4 samples per pixel; Averaged gets their averages.
  unsigned Drawn = 0, Averaged = 0;
  unsigned DrawnColor = 0, DrawnDepth = 0, AveragedColor = 0; // renderbuffers
};

}
