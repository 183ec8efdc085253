// SPDX-License-Identifier: BSD-3-Clause
// A chunk of a surface in the graphics memory. Internal to viewer/mobile.
#pragma once

#include "viewer/mobile/SurfaceChunks.h"

#include <GLES3/gl3.h>

#include <array>
#include <cstddef>

namespace kdstream
{

enum AttributePlace : GLuint // as `location` in GlesShaders.h
{
  position = 0,
  normal = 1,
  color = 2,
  radius = 3,
  away = 4,
  parentNormal = 5,
  place = 6
};

struct GlesChunk
{
  GLuint vertexArray = 0;
  // Buffers of vertices, colours (0 without), indices (for a cloud: radii), geomorphs (0 without)
  // and texture coordinates (0 without).
  std::array<GLuint, 5> buffers{};
  GLsizei count = 0;        // of indices, or points of a cloud
  std::size_t bytes = 0;    // of all buffers, and
  std::size_t morphing = 0; // of the geomorph buffer
};

// glGetError reports whether there was memory for it.
GlesChunk UploadChunk(const SurfaceChunk& content);
void FreeChunk(const GlesChunk& chunk);
// Frees the earlier positions after a geomorph has ended.
void StopMorphingOf(GlesChunk& chunk);

}
