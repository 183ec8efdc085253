// SPDX-License-Identifier: BSD-3-Clause
// A chunk of a surface in graphics memory: see GlesChunk.h.
#include "viewer/mobile/GlesChunk.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

template <class T>
GLuint MakeBuffer(GlesChunk& chunk, GLenum target, const std::vector<T>& content)
{
  chunk.bytes += content.size() * sizeof(T);
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(target, buffer);
  glBufferData(
    target, static_cast<GLsizeiptr>(content.size() * sizeof(T)), content.data(), GL_STATIC_DRAW);
  return buffer;
}

}

GlesChunk UploadChunk(const SurfaceChunk& content)
{
  GlesChunk chunk;
  glGenVertexArrays(1, &chunk.vertexArray);
  glBindVertexArray(chunk.vertexArray);
  chunk.buffers[0] = MakeBuffer(chunk, GL_ARRAY_BUFFER, content.vertices);
  glVertexAttribPointer(
    AttributePlace::position, 3, GL_FLOAT, GL_FALSE, sizeof(ChunkVertex), nullptr);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL takes an offset as a pointer
  const auto* normals = reinterpret_cast<const void*>(offsetof(ChunkVertex, normal));
  glVertexAttribPointer(
    AttributePlace::normal, 4, GL_INT_2_10_10_10_REV, GL_TRUE, sizeof(ChunkVertex), normals);
  glEnableVertexAttribArray(AttributePlace::position);
  glEnableVertexAttribArray(AttributePlace::normal);
  if (!content.colors.empty())
  {
    chunk.buffers[1] = MakeBuffer(chunk, GL_ARRAY_BUFFER, content.colors);
    glVertexAttribPointer(AttributePlace::color, 4, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
    glEnableVertexAttribArray(AttributePlace::color);
  }
  chunk.count = static_cast<GLsizei>(content.vertices.size());
  if (!content.radii.empty())
  {
    chunk.buffers[2] = MakeBuffer(chunk, GL_ARRAY_BUFFER, content.radii);
    glVertexAttribPointer(AttributePlace::radius, 1, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(AttributePlace::radius);
  }
  if (!content.geomorphs.empty())
  {
    chunk.buffers[3] = MakeBuffer(chunk, GL_ARRAY_BUFFER, content.geomorphs);
    chunk.morphing = content.geomorphs.size() * sizeof(GeomorphVertex);
    glVertexAttribPointer(
      AttributePlace::away, 3, GL_FLOAT, GL_FALSE, sizeof(GeomorphVertex), nullptr);
    // NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL takes an offset as a pointer
    const auto* parent = reinterpret_cast<const void*>(offsetof(GeomorphVertex, normal));
    glVertexAttribPointer(AttributePlace::parentNormal, 4, GL_INT_2_10_10_10_REV, GL_TRUE,
      sizeof(GeomorphVertex), parent);
    glEnableVertexAttribArray(AttributePlace::away);
    glEnableVertexAttribArray(AttributePlace::parentNormal);
  }
  if (!content.places.empty())
  {
    chunk.buffers[4] = MakeBuffer(chunk, GL_ARRAY_BUFFER, content.places);
    glVertexAttribPointer(AttributePlace::place, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(AttributePlace::place);
  }
  if (!content.indices.empty())
  {
    chunk.buffers[2] = MakeBuffer(chunk, GL_ELEMENT_ARRAY_BUFFER, content.indices);
    chunk.count = static_cast<GLsizei>(content.indices.size());
  }
  glBindVertexArray(0);
  return chunk;
}

void FreeChunk(const GlesChunk& chunk)
{
  glDeleteVertexArrays(1, &chunk.vertexArray);
  glDeleteBuffers(static_cast<GLsizei>(chunk.buffers.size()), chunk.buffers.data());
}

void StopMorphingOf(GlesChunk& chunk)
{
  if (chunk.buffers[3] != 0)
  {
    glBindVertexArray(chunk.vertexArray);
    glDisableVertexAttribArray(AttributePlace::away);
    glDisableVertexAttribArray(AttributePlace::parentNormal);
    glDeleteBuffers(1, &chunk.buffers[3]);
    chunk.buffers[3] = 0;
    chunk.bytes -= std::exchange(chunk.morphing, 0);
  }
}

}
