// SPDX-License-Identifier: BSD-3-Clause
// A shader program of OpenGL ES 3.0. Internal to viewer/mobile.
#pragma once

#include "filters/core/Result.h"

#include <GLES3/gl3.h>

#include <initializer_list>

namespace kdstream
{

// Compiles and links the concatenated texts. `name` is for messages.
// Errors: Unsupported, with what the driver says.
Result<GLuint> MakeProgram(const char* name, std::initializer_list<const char*> vertexTexts,
  std::initializer_list<const char*> fragmentTexts);

}
