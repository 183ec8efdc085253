// SPDX-License-Identifier: BSD-3-Clause
// An OpenGL context on EGL without a display server (doc/design.md#pictures-without-a-screen).
//
// Steps:
// 1. open libEGL
// 2. find a display that needs no display server: Mesa's surfaceless platform or, if that fails,
//    the devices one by one. The display is initialised once and kept.
// 3. choose a configuration
// 4. create a context and a pbuffer of one pixel. VTK draws into framebuffer objects of its own, so
//    EGL need not know the size of a window.
#include "viewer/offscreen/GlContext.h"
#include "viewer/offscreen/SharedLibrary.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{
namespace
{

struct Egl
{
  decltype(&eglBindAPI) bindApi = nullptr;
  decltype(&eglChooseConfig) chooseConfig = nullptr;
  decltype(&eglCreateContext) createContext = nullptr;
  decltype(&eglCreatePbufferSurface) createPbufferSurface = nullptr;
  decltype(&eglDestroyContext) destroyContext = nullptr;
  decltype(&eglDestroySurface) destroySurface = nullptr;
  decltype(&eglGetCurrentContext) getCurrentContext = nullptr;
  decltype(&eglGetError) getError = nullptr;
  decltype(&eglGetProcAddress) getProcAddress = nullptr;
  decltype(&eglInitialize) initialize = nullptr;
  decltype(&eglMakeCurrent) makeCurrent = nullptr;
  decltype(&eglTerminate) terminate = nullptr;

  EGLDisplay display = EGL_NO_DISPLAY;
  EGLConfig config = nullptr;
};

// Filled once by OpenEgl; contexts exist only after that.
std::optional<Egl> openedEgl;

GlFunction FindInEgl(const char* function)
{
  return openedEgl ? openedEgl->getProcAddress(function) : nullptr;
}

constexpr GlLibrary eglLibrary{ "EGL", &FindInEgl };

std::string DescribeError(const Egl& egl)
{
  std::array<char, 32> text{};
  std::snprintf(
    text.data(), text.size(), "EGL error 0x%04x", static_cast<unsigned>(egl.getError()));
  return text.data();
}

Result<Egl> LoadFunctions()
{
  const Result<SharedLibrary> library = SharedLibrary::Open({ "libEGL.so.1", "libEGL.so" });
  if (!library)
  {
    return Error{ ErrorCode::NotFound, "EGL: no library: " + library.GetError().message };
  }
  Egl egl;
  const bool complete = library->Find("eglBindAPI", egl.bindApi) &&
                        library->Find("eglChooseConfig", egl.chooseConfig) &&
                        library->Find("eglCreateContext", egl.createContext) &&
                        library->Find("eglCreatePbufferSurface", egl.createPbufferSurface) &&
                        library->Find("eglDestroyContext", egl.destroyContext) &&
                        library->Find("eglDestroySurface", egl.destroySurface) &&
                        library->Find("eglGetCurrentContext", egl.getCurrentContext) &&
                        library->Find("eglGetError", egl.getError) &&
                        library->Find("eglGetProcAddress", egl.getProcAddress) &&
                        library->Find("eglInitialize", egl.initialize) &&
                        library->Find("eglMakeCurrent", egl.makeCurrent) &&
                        library->Find("eglTerminate", egl.terminate);
  if (!complete)
  {
    return Error{ ErrorCode::Unsupported, "EGL: libEGL lacks functions of EGL 1.4" };
  }
  return egl;
}

// Displays that need no display server, the most suitable first; not initialised yet.
std::vector<EGLDisplay> FindDisplays(const Egl& egl)
{
  std::vector<EGLDisplay> displays;
  const auto getPlatformDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
    egl.getProcAddress("eglGetPlatformDisplayEXT"));
  if (!getPlatformDisplay)
  {
    return displays;
  }
  const auto add = [&](EGLenum platform, void* native)
  {
    const EGLDisplay display = getPlatformDisplay(platform, native, nullptr);
    if (display != EGL_NO_DISPLAY)
    {
      displays.push_back(display);
    }
  };
  add(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
  const auto queryDevices =
    reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.getProcAddress("eglQueryDevicesEXT"));
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (queryDevices &&
      queryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE)
  {
    for (EGLint i = 0; i < count; ++i)
    {
      add(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<std::size_t>(i)]);
    }
  }
  return displays;
}

// Initialises `display` and chooses its configuration.
Status UseDisplay(Egl& egl, EGLDisplay display)
{
  EGLint major = 0;
  EGLint minor = 0;
  if (!egl.initialize(display, &major, &minor))
  {
    return Error{ ErrorCode::NotFound, "EGL: no device: " + DescribeError(egl) };
  }
  constexpr std::array<EGLint, 15> wanted{ EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
    EGL_OPENGL_BIT, EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8, EGL_ALPHA_SIZE, 8,
    EGL_DEPTH_SIZE, 24, EGL_NONE };
  EGLint count = 0;
  if (!egl.chooseConfig(display, wanted.data(), &egl.config, 1, &count) || count == 0)
  {
    egl.terminate(display);
    return Error{ ErrorCode::NotFound,
      "EGL: no configuration with desktop OpenGL, 8 bits a colour and 24 bits of depth" };
  }
  egl.display = display;
  return {};
}

// The EGL of this process. If opening it fails, the next call tries again.
Result<const Egl*> OpenEgl()
{
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  if (openedEgl)
  {
    return &*openedEgl;
  }
  Result<Egl> egl = LoadFunctions();
  KDSTREAM_TRY(egl);
  Status status = Error{ ErrorCode::NotFound, "EGL: no device works without a display" };
  for (const EGLDisplay display : FindDisplays(*egl))
  {
    status = UseDisplay(*egl, display);
    if (status)
    {
      openedEgl = *egl;
      return &*openedEgl;
    }
  }
  return status.GetError();
}

class EglContext final : public GlContext
{
public:
  explicit EglContext(const Egl& egl)
    : Functions(egl)
  {
  }

  ~EglContext() override
  {
    this->LetGo();
    if (this->Surface != EGL_NO_SURFACE)
    {
      this->Functions.destroySurface(this->Functions.display, this->Surface);
    }
    if (this->Context != EGL_NO_CONTEXT)
    {
      this->Functions.destroyContext(this->Functions.display, this->Context);
    }
  }

  Status Create()
  {
    const Egl& egl = this->Functions;
    constexpr std::array<EGLint, 7> contextAttributes{ EGL_CONTEXT_MAJOR_VERSION, 3,
      EGL_CONTEXT_MINOR_VERSION, 2, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE };
    egl.bindApi(EGL_OPENGL_API);
    this->Context =
      egl.createContext(egl.display, egl.config, EGL_NO_CONTEXT, contextAttributes.data());
    if (this->Context == EGL_NO_CONTEXT)
    {
      return Error{ ErrorCode::Unsupported,
        "EGL: no context with OpenGL 3.2 core: " + DescribeError(egl) };
    }
    constexpr std::array<EGLint, 5> surfaceAttributes{ EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE };
    this->Surface = egl.createPbufferSurface(egl.display, egl.config, surfaceAttributes.data());
    if (this->Surface == EGL_NO_SURFACE)
    {
      return Error{ ErrorCode::Unsupported, "EGL: no pbuffer: " + DescribeError(egl) };
    }
    return {};
  }

protected:
  const GlLibrary& Library() const override { return eglLibrary; }

  Status Bind() override
  {
    const Egl& egl = this->Functions;
    // The bound API is a state of the thread, and other code may have changed it.
    egl.bindApi(EGL_OPENGL_API);
    if (!egl.makeCurrent(egl.display, this->Surface, this->Surface, this->Context))
    {
      return Error{ ErrorCode::InputOutput,
        "EGL: the context cannot be made current: " + DescribeError(egl) };
    }
    return {};
  }

  void Unbind() override
  {
    this->Functions.makeCurrent(
      this->Functions.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  bool IsBound() const override { return this->Functions.getCurrentContext() == this->Context; }

private:
  const Egl& Functions;
  EGLContext Context = EGL_NO_CONTEXT;
  EGLSurface Surface = EGL_NO_SURFACE;
};

}

Result<std::unique_ptr<GlContext>> MakeEglContext()
{
  const Result<const Egl*> egl = OpenEgl();
  KDSTREAM_TRY(egl);
  auto context = std::make_unique<EglContext>(**egl);
  KDSTREAM_TRY(context->Create());
  return std::unique_ptr<GlContext>(std::move(context));
}

}
