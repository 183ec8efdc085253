// SPDX-License-Identifier: BSD-3-Clause
// A shared library that is opened when it is first needed. Internal to viewer/offscreen.
//
// EGL and OSMesa are opened this way. So a program starts even if one is missing, and can report
// that. Also, OSMesa exports all symbols of OpenGL; opened this way, they do not replace others.
#pragma once

#include "filters/core/Result.h"

#include <dlfcn.h>

#include <initializer_list>
#include <string>

namespace kdstream
{

// The library stays open until the program ends, because drivers fail if they are closed.
class SharedLibrary
{
public:
  // Opens the first of `names` that exists. Errors: NotFound, with the loader's message for the
  // last name.
  static Result<SharedLibrary> Open(std::initializer_list<const char*> names)
  {
    std::string reason;
    for (const char* name : names)
    {
      if (void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL))
      {
        return SharedLibrary(handle);
      }
      reason = dlerror();
    }
    return Error{ ErrorCode::NotFound, reason };
  }

  // Sets `function` to the symbol `name`; false if there is none.
  template <class F>
  bool Find(const char* name, F*& function) const
  {
    function = reinterpret_cast<F*>(dlsym(this->Handle, name));
    return function != nullptr;
  }

private:
  explicit SharedLibrary(void* handle)
    : Handle(handle)
  {
  }
  void* Handle;
};

}
