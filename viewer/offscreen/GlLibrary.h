// SPDX-License-Identifier: BSD-3-Clause
// Decides whose OpenGL the process calls: EGL's, OSMesa's, or the system's (GLX). Internal to
// viewer/offscreen.
//
// A stock VTK calls OpenGL in two ways: most functions by the pointers of GLEW, which are one
// global table, and the oldest functions (OpenGL 1.0 and 1.1) as linked symbols. Both are filled
// for GLX only. GlSymbols.cxx, which is linked into the executable, replaces both. This file
// selects the library that it calls, and fills the tables anew when a context of another library
// becomes current.
#pragma once

#include "filters/core/Result.h"

namespace kdstream
{

using GlFunction = void (*)();

// A library that has OpenGL contexts of its own. There is one object a library: they are compared
// by address.
struct GlLibrary
{
  const char* name;
  GlFunction (*find)(const char* function);
};

// The OpenGL to which the program is linked, with GLX: used when none of our contexts is current.
const GlLibrary& SystemGlLibrary();

// The library that was last given to UseGlLibrary; at first the system's.
const GlLibrary& GlLibraryInUse();

// Makes all calls of OpenGL go to `library`. O(1) if they do already, else about 1 ms.
// REQUIRES: a context of that library is current. Threads: the tables belong to the process, so
// contexts of different libraries must be used from one thread. Errors: NotFound for a function
// that the library lacks, Unsupported if GLEW refuses the context.
Status UseGlLibrary(const GlLibrary& library);

// How GlSymbols.cxx makes itself known, before main().
struct GlSymbols
{
  // Points the linked symbols at those of `library`. Returns the name of a function that is missing
  // there, or null.
  const char* (*load)(const GlLibrary& library) = nullptr;
  // The exported glXGetProcAddressARB.
  GlFunction getProcAddress = nullptr;
  // The function of this name in the linked libraries; null if there is none.
  GlFunction (*findInSystem)(const char* function) = nullptr;
};
void RegisterGlSymbols(const GlSymbols& symbols);

// Errors: Unsupported if the program was linked without GlSymbols.cxx, or does not export it.
Status CheckGlSymbols();

}
