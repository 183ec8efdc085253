// SPDX-License-Identifier: BSD-3-Clause
// The OpenGL symbols that an executable exports so that a stock VTK can draw without GLX
// (doc/design.md#pictures-without-a-screen).
//
// Debian's VTK 9.1 has only GLX windows. Two kinds of its calls would go to GLX, whatever context
// is current:
//  - GLEW asks `glXGetProcAddressARB` for every function of OpenGL 1.2 and later;
//  - the functions of OpenGL 1.0 and 1.1 are symbols of libOpenGL or libGL, which know nothing of
//    OSMesa.
// A symbol of the executable takes precedence over the same symbol of any shared library. So this
// file defines all these symbols, and passes each call to the library whose context is current
// (GlLibrary.h): EGL, OSMesa, or the system's. Stock VTK windows on X11 still work: if none of our
// contexts is current, every call is passed to the system's library.
//
// So this file must be linked into the *executable* as an object file (an archive member would be
// left out), and the executable must export its symbols. kdstream_enable_offscreen(target) in
// KdStreamOffscreen.cmake does both. If VTK has windows of its own for EGL and OSMesa, this file is
// not needed, and not compiled.
#include "viewer/offscreen/GlLibrary.h"

#include <GL/glcorearb.h>
#include <dlfcn.h>

#include <cstring>

// Every function of OpenGL 1.0 and 1.1 that is still in the core profile: result, name, parameters,
// arguments.
// clang-format off
#define KDSTREAM_FOR_EACH_GL_FUNCTION(X) \
  X(void, glCullFace, (GLenum mode), (mode)) \
  X(void, glFrontFace, (GLenum mode), (mode)) \
  X(void, glHint, (GLenum target, GLenum mode), (target, mode)) \
  X(void, glLineWidth, (GLfloat width), (width)) \
  X(void, glPointSize, (GLfloat size), (size)) \
  X(void, glPolygonMode, (GLenum face, GLenum mode), (face, mode)) \
  X(void, glScissor, (GLint x, GLint y, GLsizei width, GLsizei height), (x, y, width, height)) \
  X(void, glTexParameterf, (GLenum target, GLenum pname, GLfloat param), (target, pname, param)) \
  X(void, glTexParameterfv, (GLenum target, GLenum pname, const GLfloat* params), (target, pname, params)) \
  X(void, glTexParameteri, (GLenum target, GLenum pname, GLint param), (target, pname, param)) \
  X(void, glTexParameteriv, (GLenum target, GLenum pname, const GLint* params), (target, pname, params)) \
  X(void, glTexImage1D, (GLenum target, GLint level, GLint internalformat, GLsizei width, GLint border, GLenum format, GLenum type, const void* pixels), (target, level, internalformat, width, border, format, type, pixels)) \
  X(void, glTexImage2D, (GLenum target, GLint level, GLint internalformat, GLsizei width, GLsizei height, GLint border, GLenum format, GLenum type, const void* pixels), (target, level, internalformat, width, height, border, format, type, pixels)) \
  X(void, glDrawBuffer, (GLenum buf), (buf)) \
  X(void, glClear, (GLbitfield mask), (mask)) \
  X(void, glClearColor, (GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha), (red, green, blue, alpha)) \
  X(void, glClearStencil, (GLint s), (s)) \
  X(void, glClearDepth, (GLdouble depth), (depth)) \
  X(void, glStencilMask, (GLuint mask), (mask)) \
  X(void, glColorMask, (GLboolean red, GLboolean green, GLboolean blue, GLboolean alpha), (red, green, blue, alpha)) \
  X(void, glDepthMask, (GLboolean flag), (flag)) \
  X(void, glDisable, (GLenum cap), (cap)) \
  X(void, glEnable, (GLenum cap), (cap)) \
  X(void, glFinish, (), ()) \
  X(void, glFlush, (), ()) \
  X(void, glBlendFunc, (GLenum sfactor, GLenum dfactor), (sfactor, dfactor)) \
  X(void, glLogicOp, (GLenum opcode), (opcode)) \
  X(void, glStencilFunc, (GLenum func, GLint ref, GLuint mask), (func, ref, mask)) \
  X(void, glStencilOp, (GLenum fail, GLenum zfail, GLenum zpass), (fail, zfail, zpass)) \
  X(void, glDepthFunc, (GLenum func), (func)) \
  X(void, glPixelStoref, (GLenum pname, GLfloat param), (pname, param)) \
  X(void, glPixelStorei, (GLenum pname, GLint param), (pname, param)) \
  X(void, glReadBuffer, (GLenum src), (src)) \
  X(void, glReadPixels, (GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type, void* pixels), (x, y, width, height, format, type, pixels)) \
  X(void, glGetBooleanv, (GLenum pname, GLboolean* data), (pname, data)) \
  X(void, glGetDoublev, (GLenum pname, GLdouble* data), (pname, data)) \
  X(GLenum, glGetError, (), ()) \
  X(void, glGetFloatv, (GLenum pname, GLfloat* data), (pname, data)) \
  X(void, glGetIntegerv, (GLenum pname, GLint* data), (pname, data)) \
  X(const GLubyte*, glGetString, (GLenum name), (name)) \
  X(void, glGetTexImage, (GLenum target, GLint level, GLenum format, GLenum type, void* pixels), (target, level, format, type, pixels)) \
  X(void, glGetTexParameterfv, (GLenum target, GLenum pname, GLfloat* params), (target, pname, params)) \
  X(void, glGetTexParameteriv, (GLenum target, GLenum pname, GLint* params), (target, pname, params)) \
  X(void, glGetTexLevelParameterfv, (GLenum target, GLint level, GLenum pname, GLfloat* params), (target, level, pname, params)) \
  X(void, glGetTexLevelParameteriv, (GLenum target, GLint level, GLenum pname, GLint* params), (target, level, pname, params)) \
  X(GLboolean, glIsEnabled, (GLenum cap), (cap)) \
  X(void, glDepthRange, (GLdouble n, GLdouble f), (n, f)) \
  X(void, glViewport, (GLint x, GLint y, GLsizei width, GLsizei height), (x, y, width, height)) \
  X(void, glDrawArrays, (GLenum mode, GLint first, GLsizei count), (mode, first, count)) \
  X(void, glDrawElements, (GLenum mode, GLsizei count, GLenum type, const void* indices), (mode, count, type, indices)) \
  X(void, glPolygonOffset, (GLfloat factor, GLfloat units), (factor, units)) \
  X(void, glCopyTexImage1D, (GLenum target, GLint level, GLenum internalformat, GLint x, GLint y, GLsizei width, GLint border), (target, level, internalformat, x, y, width, border)) \
  X(void, glCopyTexImage2D, (GLenum target, GLint level, GLenum internalformat, GLint x, GLint y, GLsizei width, GLsizei height, GLint border), (target, level, internalformat, x, y, width, height, border)) \
  X(void, glCopyTexSubImage1D, (GLenum target, GLint level, GLint xoffset, GLint x, GLint y, GLsizei width), (target, level, xoffset, x, y, width)) \
  X(void, glCopyTexSubImage2D, (GLenum target, GLint level, GLint xoffset, GLint yoffset, GLint x, GLint y, GLsizei width, GLsizei height), (target, level, xoffset, yoffset, x, y, width, height)) \
  X(void, glTexSubImage1D, (GLenum target, GLint level, GLint xoffset, GLsizei width, GLenum format, GLenum type, const void* pixels), (target, level, xoffset, width, format, type, pixels)) \
  X(void, glTexSubImage2D, (GLenum target, GLint level, GLint xoffset, GLint yoffset, GLsizei width, GLsizei height, GLenum format, GLenum type, const void* pixels), (target, level, xoffset, yoffset, width, height, format, type, pixels)) \
  X(void, glBindTexture, (GLenum target, GLuint texture), (target, texture)) \
  X(void, glDeleteTextures, (GLsizei n, const GLuint* textures), (n, textures)) \
  X(void, glGenTextures, (GLsizei n, GLuint* textures), (n, textures)) \
  X(GLboolean, glIsTexture, (GLuint texture), (texture))
// clang-format on

namespace
{

// Types and parameter lists of a macro cannot be put in parentheses.
// NOLINTBEGIN(bugprone-macro-parentheses)
struct Functions
{
#define KDSTREAM_POINTER(result, name, parameters, arguments) result(*name) parameters;
  KDSTREAM_FOR_EACH_GL_FUNCTION(KDSTREAM_POINTER)
#undef KDSTREAM_POINTER
};

constinit Functions functions{};

const char* LoadFunctions(const kdstream::GlLibrary& library)
{
  const char* missing = nullptr;
#define KDSTREAM_LOAD(result, name, parameters, arguments)          \
  if (const kdstream::GlFunction found = library.find(#name))       \
  {                                                                 \
    functions.name = reinterpret_cast<result(*) parameters>(found); \
  }                                                                 \
  else                                                              \
  {                                                                 \
    missing = #name;                                                \
  }
  KDSTREAM_FOR_EACH_GL_FUNCTION(KDSTREAM_LOAD)
#undef KDSTREAM_LOAD
  return missing;
}
// NOLINTEND(bugprone-macro-parentheses)

}

extern "C"
{

#define KDSTREAM_FORWARD(result, name, parameters, arguments)   \
  __attribute__((visibility("default"))) result name parameters \
  {                                                             \
    return functions.name arguments;                            \
  }
  KDSTREAM_FOR_EACH_GL_FUNCTION(KDSTREAM_FORWARD)
#undef KDSTREAM_FORWARD

  // Functions of GLX (their names start with glX) are always the system's. A plain dlsym would find
  // this function again; find uses RTLD_NEXT, so a request to the system never comes back here.
  __attribute__((visibility("default"))) kdstream::GlFunction glXGetProcAddressARB(
    const unsigned char* name)
  {
    const auto* text = reinterpret_cast<const char*>(name);
    const bool ofGlx = std::strncmp(text, "glX", 3) == 0;
    return (ofGlx ? kdstream::SystemGlLibrary() : kdstream::GlLibraryInUse()).find(text);
  }
}

namespace
{

// For the executable, RTLD_NEXT means the first library after it that has the name. So this never
// finds our own symbols, and never OSMesa's, because that library is opened with RTLD_LOCAL.
kdstream::GlFunction FindInSystem(const char* function)
{
  if (void* symbol = dlsym(RTLD_NEXT, function))
  {
    return reinterpret_cast<kdstream::GlFunction>(symbol);
  }
  using GetProcAddress = kdstream::GlFunction (*)(const unsigned char*);
  const auto getProcAddress =
    reinterpret_cast<GetProcAddress>(dlsym(RTLD_NEXT, "glXGetProcAddressARB"));
  return getProcAddress ? getProcAddress(reinterpret_cast<const unsigned char*>(function))
                        : nullptr;
}

[[maybe_unused]] const bool registered = []
{
  kdstream::RegisterGlSymbols({ &LoadFunctions,
    reinterpret_cast<kdstream::GlFunction>(&glXGetProcAddressARB), &FindInSystem });
  LoadFunctions(kdstream::SystemGlLibrary());
  return true;
}();

}
