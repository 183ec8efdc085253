// SPDX-License-Identifier: BSD-3-Clause
// Pictures by OpenGL ES 3 without a screen: see EglOffscreen.h.
//
// Steps:
// 1. get and initialise the surfaceless display
// 2. choose a configuration, and create a context of OpenGL ES 3
// 3. create a framebuffer with 4 samples per pixel to draw into, and one with a single sample for
//    their averages.
#include "viewer/mobile/Testing/EglOffscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace kdstream
{
namespace
{

constexpr GLsizei samples = 4; // as in viewer/rendering; every OpenGL ES 3.0 has at least 4

std::string Describe(const char* what, unsigned code)
{
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), " error 0x%04x", code);
  return what + std::string(text.data());
}

Result<EGLDisplay> OpenDisplay()
{
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!extensions ||
      std::string_view(extensions).find("EGL_MESA_platform_surfaceless") == std::string_view::npos)
  {
    return Error{ ErrorCode::NotFound,
      "EGL: no driver that draws without a screen (EGL_MESA_platform_surfaceless)" };
  }
  const EGLDisplay display =
    eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE)
  {
    return Error{ ErrorCode::NotFound, "EGL: the surfaceless display does not work: " +
                                         Describe("EGL", static_cast<unsigned>(eglGetError())) };
  }
  return display;
}

GLuint MakeStorage(GLenum attachment, GLsizei sampleCount, GLenum format, int width, int height)
{
  GLuint buffer = 0;
  glGenRenderbuffers(1, &buffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, sampleCount, format, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  return buffer;
}

}

EglOffscreen::EglOffscreen(int width, int height)
  : Width(width)
  , Height(height)
{
}

EglOffscreen::~EglOffscreen()
{
  if (!this->Context)
  {
    return;
  }
  // Its framebuffers are destroyed with the context.
  if (eglGetCurrentContext() == this->Context)
  {
    eglMakeCurrent(this->Display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(this->Display, this->Context);
}

Result<std::unique_ptr<EglOffscreen>> EglOffscreen::Make(int width, int height)
{
  if (width < 1 || height < 1)
  {
    return Error{ ErrorCode::InvalidArgument, "a picture of " + std::to_string(width) + " x " +
                                                std::to_string(height) +
                                                " pixels cannot be drawn" };
  }
  std::unique_ptr<EglOffscreen> made(new EglOffscreen(width, height));
  KDSTREAM_TRY(made->MakeContext());
  KDSTREAM_TRY(made->MakeFramebuffers());
  return made;
}

Status EglOffscreen::MakeContext()
{
  const Result<EGLDisplay> display = OpenDisplay();
  KDSTREAM_TRY(display);
  this->Display = *display;
  eglBindAPI(EGL_OPENGL_ES_API);
  constexpr std::array<EGLint, 5> wanted{ EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE,
    EGL_OPENGL_ES3_BIT, EGL_NONE };
  EGLConfig config = nullptr;
  EGLint count = 0;
  constexpr std::array<EGLint, 3> version{ EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE };
  if (eglChooseConfig(this->Display, wanted.data(), &config, 1, &count) == EGL_TRUE && count > 0)
  {
    this->Context = eglCreateContext(this->Display, config, EGL_NO_CONTEXT, version.data());
  }
  if (!this->Context)
  {
    return Error{ ErrorCode::Unsupported, "EGL: no context of OpenGL ES 3.0: " +
                                            Describe("EGL", static_cast<unsigned>(eglGetError())) };
  }
  return this->MakeCurrent();
}

Status EglOffscreen::MakeFramebuffers()
{
  GLint most = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  const std::string size = std::to_string(this->Width) + " x " + std::to_string(this->Height);
  if (std::max(this->Width, this->Height) > most)
  {
    return Error{ ErrorCode::Unsupported,
      "OpenGL ES: a picture of " + size + " pixels: sides are at most " + std::to_string(most) };
  }
  glGenFramebuffers(1, &this->Averaged);
  glBindFramebuffer(GL_FRAMEBUFFER, this->Averaged);
  this->AveragedColor = MakeStorage(GL_COLOR_ATTACHMENT0, 0, GL_RGBA8, this->Width, this->Height);
  glGenFramebuffers(1, &this->Drawn);
  glBindFramebuffer(GL_FRAMEBUFFER, this->Drawn);
  this->DrawnColor =
    MakeStorage(GL_COLOR_ATTACHMENT0, samples, GL_RGBA8, this->Width, this->Height);
  this->DrawnDepth =
    MakeStorage(GL_DEPTH_ATTACHMENT, samples, GL_DEPTH_COMPONENT24, this->Width, this->Height);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  const GLenum error = glGetError();
  if (status != GL_FRAMEBUFFER_COMPLETE || error != GL_NO_ERROR)
  {
    return Error{ ErrorCode::Unsupported, "OpenGL ES: no framebuffer of " + size + " pixels: " +
                                            Describe("OpenGL", error ? error : status) };
  }
  return {};
}

Status EglOffscreen::MakeCurrent()
{
  // The bound API is a state of the thread, and other code may have changed it.
  eglBindAPI(EGL_OPENGL_ES_API);
  if (eglMakeCurrent(this->Display, EGL_NO_SURFACE, EGL_NO_SURFACE, this->Context) != EGL_TRUE)
  {
    return Error{ ErrorCode::Unsupported, "EGL: the context cannot be made current: " +
                                            Describe("EGL", static_cast<unsigned>(eglGetError())) };
  }
  glBindFramebuffer(GL_FRAMEBUFFER, this->Drawn);
  return {};
}

Result<std::vector<std::uint8_t>> EglOffscreen::Pixels()
{
  // Clears the errors of other code. A lost context may report its error for ever, so the number of
  // tries is limited.
  for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; ++i)
  {
  }
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, this->Averaged);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, this->Drawn);
  glDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, this->Width, this->Height, 0, 0, this->Width, this->Height,
    GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, this->Averaged);
  const auto width = static_cast<std::size_t>(this->Width);
  const auto height = static_cast<std::size_t>(this->Height);
  std::vector<std::uint8_t> read(4 * width * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, this->Width, this->Height, GL_RGBA, GL_UNSIGNED_BYTE, read.data());
  glBindFramebuffer(GL_FRAMEBUFFER, this->Drawn);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
  {
    return Error{ ErrorCode::InputOutput,
      "OpenGL ES gives back no pixels: " + Describe("OpenGL", error) };
  }
  // OpenGL returns the lowest row first.
  std::vector<std::uint8_t> pixels(3 * width * height);
  for (std::size_t y = 0; y < height; ++y)
  {
    const std::uint8_t* from = read.data() + 4 * width * (height - 1 - y);
    std::uint8_t* to = pixels.data() + 3 * width * y;
    for (std::size_t x = 0; x < width; ++x, from += 4, to += 3)
    {
      std::copy_n(from, 3, to);
    }
  }
  return pixels;
}

}
