// SPDX-License-Identifier: BSD-3-Clause
// A shader program of OpenGL ES 3.0: see GlesPrograms.h.
#include "viewer/mobile/GlesPrograms.h"

#include <array>
#include <string>

namespace kdstream
{
namespace
{

Error Refused(const char* name, const char* what, const char* log)
{
  return Error{ ErrorCode::Unsupported,
    std::string("OpenGL ES: the ") + name + " shader " + what + ": " +
      (*log ? log : "the driver gives no reason; the context may be lost") };
}

// glCreateShader gives 0 if there is no context.
Result<GLuint> CompileShader(
  const char* name, GLenum kind, std::initializer_list<const char*> texts)
{
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, static_cast<GLsizei>(texts.size()), texts.begin(), nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != GL_TRUE)
  {
    std::array<char, 1024> log{};
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteShader(shader);
    return Refused(name, "does not compile", log.data());
  }
  return shader;
}

}

Result<GLuint> MakeProgram(const char* name, std::initializer_list<const char*> vertexTexts,
  std::initializer_list<const char*> fragmentTexts)
{
  const Result<GLuint> vertex = CompileShader(name, GL_VERTEX_SHADER, vertexTexts);
  KDSTREAM_TRY(vertex);
  const Result<GLuint> fragment = CompileShader(name, GL_FRAGMENT_SHADER, fragmentTexts);
  if (!fragment)
  {
    glDeleteShader(*vertex);
    return fragment.GetError();
  }
  const GLuint program = glCreateProgram();
  glAttachShader(program, *vertex);
  glAttachShader(program, *fragment);
  glLinkProgram(program);
  // The shaders are deleted with the program.
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE)
  {
    std::array<char, 1024> log{};
    glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteProgram(program);
    return Refused(name, "cannot be linked", log.data());
  }
  return program;
}

}
