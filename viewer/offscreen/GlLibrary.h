// SPDX-License-Identifier: BSD-3-Clause
// Decides which library's OpenGL the process calls: EGL's, OSMesa's, or the system's (GLX).
// Internal to viewer/offscreen.
//
// A stock VTK calls OpenGL in two ways. It calls most functions by the pointers of GLEW, which are
// one global table. It calls the oldest functions (OpenGL 1.0 and 1.1) as linked symbols. Both ways
// lead to GLX only. GlSymbols.cxx, which is linked into the executable, replaces both. This file
// selects the library that GlSymbols.cxx calls, and fills both tables again when a context of
// another library becomes current.
#pragma once

#include "filters/core/Result.h"

namespace kdstream
{

using GlFunction = void (*)();

// A library that has its own OpenGL contexts. There is one object per library, so that objects can
// be compared by address.
struct GlLibrary
{
  const char* name;
  GlFunction (*find)(const char* function);
};

// The OpenGL library that the program is linked to, with GLX: used if none of our contexts is
// current.
const GlLibrary& SystemGlLibrary();

// The library of the last call of UseGlLibrary; before the first call, the system's.
const GlLibrary& GlLibraryInUse();

// Makes all calls of OpenGL go to `library`. O(1) if they already do, otherwise about 1 ms.
// REQUIRES: a context of that library is current. Threads: the tables belong to the process, so
// contexts of different libraries must be used from one thread. Errors: NotFound for a function
// that the library lacks, Unsupported if GLEW refuses the context.
Status UseGlLibrary(const GlLibrary& library);

// GlSymbols.cxx registers itself with this before main().
struct GlSymbols
{
  // Makes the linked symbols call the functions of `library`. Returns the name of a function that
  // is missing there, or null.
  const char* (*load)(const GlLibrary& library) = nullptr;
  // The exported glXGetProcAddressARB.
  GlFunction getProcAddress = nullptr;
  // Finds the function of this name in the linked libraries; null if there is none.
  GlFunction (*findInSystem)(const char* function) = nullptr;
};
void RegisterGlSymbols(const GlSymbols& symbols);

// Errors: Unsupported if the program was linked without GlSymbols.cxx, or does not export it.
Status CheckGlSymbols();

}
