// SPDX-License-Identifier: BSD-3-Clause
// A chunk of a surface in graphics memory. Internal to viewer/mobile.
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
  // The buffers of vertices, colours, indices (for a cloud: radii), geomorphs and texture
  // coordinates. 0 if there are no colours, geomorphs or texture coordinates.
  std::array<GLuint, 5> buffers{};
  GLsizei count = 0;        // of indices; for a cloud, of points
  std::size_t bytes = 0;    // of all buffers, including
  std::size_t morphing = 0; // those of the geomorph buffer
};

// Call glGetError afterwards: it reports whether memory was sufficient.
GlesChunk UploadChunk(const SurfaceChunk& content);
void FreeChunk(const GlesChunk& chunk);
// Frees the geomorph buffer after a geomorph has ended.
void StopMorphingOf(GlesChunk& chunk);

}
