// SPDX-License-Identifier: BSD-3-Clause
// An OpenGL context of OSMesa, Mesa's renderer in main memory
// (doc/design.md#pictures-without-a-screen).
//
// OSMesa needs a buffer to draw into. It gets a buffer of one pixel, because VTK draws into
// framebuffer objects of its own.
#include "viewer/offscreen/GlContext.h"
#include "viewer/offscreen/SharedLibrary.h"

#include <GL/osmesa.h>

#include <array>
#include <mutex>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

struct OsMesa
{
  decltype(&OSMesaCreateContextAttribs) createContext = nullptr;
  decltype(&OSMesaDestroyContext) destroyContext = nullptr;
  decltype(&OSMesaGetCurrentContext) getCurrentContext = nullptr;
  decltype(&OSMesaGetProcAddress) getProcAddress = nullptr;
  decltype(&OSMesaMakeCurrent) makeCurrent = nullptr;
};

// Filled once by OpenOsMesa; contexts exist only after that.
std::optional<OsMesa> openedOsMesa;

GlFunction FindInOsMesa(const char* function)
{
  return openedOsMesa ? openedOsMesa->getProcAddress(function) : nullptr;
}

constexpr GlLibrary osMesaLibrary{ "OSMesa", &FindInOsMesa };

Result<const OsMesa*> OpenOsMesa()
{
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
  if (openedOsMesa)
  {
    return &*openedOsMesa;
  }
  const Result<SharedLibrary> library =
    SharedLibrary::Open({ "libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so" });
  if (!library)
  {
    return Error{ ErrorCode::NotFound, "OSMesa: no library: " + library.GetError().message };
  }
  OsMesa functions;
  const bool complete = library->Find("OSMesaCreateContextAttribs", functions.createContext) &&
                        library->Find("OSMesaDestroyContext", functions.destroyContext) &&
                        library->Find("OSMesaGetCurrentContext", functions.getCurrentContext) &&
                        library->Find("OSMesaGetProcAddress", functions.getProcAddress) &&
                        library->Find("OSMesaMakeCurrent", functions.makeCurrent);
  if (!complete)
  {
    return Error{ ErrorCode::Unsupported, "OSMesa: libOSMesa is older than Mesa 11.2" };
  }
  openedOsMesa = functions;
  return &*openedOsMesa;
}

class OsMesaContext final : public GlContext
{
public:
  explicit OsMesaContext(const OsMesa& functions)
    : Functions(functions)
  {
  }

  ~OsMesaContext() override
  {
    this->LetGo();
    if (this->Context)
    {
      this->Functions.destroyContext(this->Context);
    }
  }

  Status Create()
  {
    constexpr std::array<int, 11> attributes{ OSMESA_FORMAT, OSMESA_RGBA, OSMESA_DEPTH_BITS, 24,
      OSMESA_PROFILE, OSMESA_CORE_PROFILE, OSMESA_CONTEXT_MAJOR_VERSION, 3,
      OSMESA_CONTEXT_MINOR_VERSION, 2, 0 };
    this->Context = this->Functions.createContext(attributes.data(), nullptr);
    if (!this->Context)
    {
      return Error{ ErrorCode::Unsupported, "OSMesa: no context with OpenGL 3.2 core" };
    }
    return {};
  }

protected:
  const GlLibrary& Library() const override { return osMesaLibrary; }

  Status Bind() override
  {
    if (!this->Functions.makeCurrent(this->Context, this->Pixel.data(), GL_UNSIGNED_BYTE, 1, 1))
    {
      return Error{ ErrorCode::InputOutput, "OSMesa: the context cannot be made current" };
    }
    return {};
  }

  void Unbind() override { this->Functions.makeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

  bool IsBound() const override { return this->Functions.getCurrentContext() == this->Context; }

private:
  const OsMesa& Functions;
  OSMesaContext Context = nullptr;
  std::array<unsigned char, 4> Pixel{};
};

}

Result<std::unique_ptr<GlContext>> MakeOsMesaContext()
{
  const Result<const OsMesa*> functions = OpenOsMesa();
  KDSTREAM_TRY(functions);
  auto context = std::make_unique<OsMesaContext>(**functions);
  KDSTREAM_TRY(context->Create());
  return std::unique_ptr<GlContext>(std::move(context));
}

}
