// SPDX-License-Identifier: BSD-3-Clause
// Which library's OpenGL the process calls: see GlLibrary.h.
#include "viewer/offscreen/GlLibrary.h"

#include <dlfcn.h>
#include <vtk_glew.h>

#include <string>

namespace kdstream
{
namespace
{

// Constant-initialised, so that any static initialiser may call RegisterGlSymbols.
constinit GlSymbols registeredSymbols{};

GlFunction FindInSystem(const char* function)
{
  return registeredSymbols.findInSystem ? registeredSymbols.findInSystem(function) : nullptr;
}

constexpr GlLibrary systemLibrary{ "the system's OpenGL", &FindInSystem };

constinit const GlLibrary* libraryInUse = &systemLibrary;
constinit bool tablesAreFilled = true;

// Fills GLEW's table by our glXGetProcAddressARB. As its last step, GLEW may report that there is
// no GLX display. This is not an error here: only the system's contexts have a GLX display, and
// everything else has been done.
Status FillGlew(const GlLibrary& library)
{
  glewExperimental = GL_TRUE;
  const GLenum result = glewInit();
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY)
  {
    return Error{ ErrorCode::Unsupported,
      std::string("GLEW cannot use the context of ") + library.name + ": " +
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
      "the program does not export viewer/offscreen/GlSymbols.cxx (link it with the CMake function "
      "kdstream_enable_offscreen)" };
  }
  return {};
}

}
