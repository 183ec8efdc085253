// SPDX-License-Identifier: BSD-3-Clause
// Whose OpenGL the process calls: see GlLibrary.h.
#include "viewer/rendering/GlLibrary.h"

#include <dlfcn.h>
#include <vtk_glew.h>

#include <string>

namespace kdstream
{
namespace
{

// RTLD_NEXT is the first library after the executable that has the name: never our own symbols, and
// never OSMesa's, which is opened with RTLD_LOCAL.
GlFunction FindInSystem(const char* function)
{
  if (void* symbol = dlsym(RTLD_NEXT, function))
  {
    return reinterpret_cast<GlFunction>(symbol);
  }
  using GetProcAddress = GlFunction (*)(const unsigned char*);
  const auto getProcAddress =
    reinterpret_cast<GetProcAddress>(dlsym(RTLD_NEXT, "glXGetProcAddressARB"));
  return getProcAddress ? getProcAddress(reinterpret_cast<const unsigned char*>(function))
                        : nullptr;
}

constexpr GlLibrary systemLibrary{ "the system's OpenGL", &FindInSystem };

// Constant-initialised, so that RegisterGlSymbols may be called by any static initialiser.
constinit const GlLibrary* libraryInUse = &systemLibrary;
constinit bool tablesAreFilled = true;
constinit GlSymbols registeredSymbols{};

// GLEW's table is filled through our glXGetProcAddressARB. It complains of a missing GLX display,
// which only the system's contexts have, after everything else is done.
Status FillGlew(const GlLibrary& library)
{
  glewExperimental = GL_TRUE;
  const GLenum result = glewInit();
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY)
  {
    return Error{ ErrorCode::Unsupported,
      std::string("GLEW refuses the context of ") + library.name + ": " +
        reinterpret_cast<const char*>(glewGetErrorString(result)) };
  }
  return {};
}

}

const GlLibrary& SystemGlLibrary()
{
  return systemLibrary;
}

const GlLibrary& GlLibraryInUse()
{
  return *libraryInUse;
}

Status UseGlLibrary(const GlLibrary& library)
{
  if (tablesAreFilled && &library == libraryInUse)
  {
    return {};
  }
  KDSTREAM_TRY(CheckGlSymbols());
  libraryInUse = &library;
  tablesAreFilled = false;
  if (const char* missing = registeredSymbols.load(library))
  {
    return Error{ ErrorCode::NotFound, std::string(library.name) + " has no function " + missing };
  }
  Status status = FillGlew(library);
  tablesAreFilled = status.HasValue();
  return status;
}

void RegisterGlSymbols(const GlSymbols& symbols)
{
  registeredSymbols = symbols;
}

Status CheckGlSymbols()
{
  if (!registeredSymbols.load || dlsym(RTLD_DEFAULT, "glXGetProcAddressARB") !=
                                   reinterpret_cast<void*>(registeredSymbols.getProcAddress))
  {
    return Error{ ErrorCode::Unsupported,
      "the program does not export viewer/rendering/GlSymbols.cxx (link it with the CMake function "
      "kdstream_enable_offscreen)" };
  }
  return {};
}

}
