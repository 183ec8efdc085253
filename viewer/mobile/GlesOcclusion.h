// SPDX-License-Identifier: BSD-3-Clause
// Draws ambient occlusion into the phone's picture: the passes of
// viewer/session/appearance/OcclusionShaders.h with OpenGL ES 3.0. Internal to viewer/mobile.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/SessionTypes.h"

#include <GLES3/gl3.h>

#include <array>
#include <cstddef>
#include <memory>

namespace kdstream
{

// How the picture is projected: the scales of x and y, and the two terms of the depth.
using GlesProjection = std::array<float, 4>;

// Threads and context: as for GlesRenderer.
class GlesOcclusion
{
public:
  // Errors: those of MakeProgram.
  static Result<std::unique_ptr<GlesOcclusion>> Make();
  ~GlesOcclusion();
  GlesOcclusion(const GlesOcclusion&) = delete;
  GlesOcclusion& operator=(const GlesOcclusion&) = delete;

  // Call this when the context was lost: nothing is deleted.
  void Forget();

  // The bytes of its textures: per pixel, 4 for depth (3 are used) and 1 for each of the other two.
  std::size_t Bytes() const
  {
    return std::size_t{ 6 } * static_cast<std::size_t>(this->Width) *
           static_cast<std::size_t>(this->Height);
  }

  // Binds and clears a framebuffer for the depths of the model, with half the picture's sides. Draw
  // the model next. Returns false if memory is insufficient; then the picture is drawn without
  // occlusion.
  bool BeginDepths(const Viewport& picture);
  // Computes the occlusion, and binds the framebuffer that was bound before BeginDepths. facet:
  // FacetLength, in the projection's unit. REQUIRES: an empty vertex array is bound.
  void EndDepths(const GlesProjection& projection, double facet);
  // Sets the uniforms of `darkened` (GlesShaders.h) in this program, so that the program multiplies
  // what it draws by the occlusion from EndDepths. REQUIRES: the program is in use, and the
  // textures are still bound.
  void Aim(GLuint program) const;

private:
  struct Target
  {
    GLuint texture = 0, framebuffer = 0;
  };
  enum Index : std::size_t
  {
    depths, // the renderer draws these
    occluded,
    mean,
    count
  };

  GlesOcclusion() = default;
  bool Resize(int width, int height);
  void Free();
  void Fill(Index target) const;

  GLuint Occlude = 0, Average = 0; // programs
  std::array<Target, count> Targets{};
  int Width = 0, Height = 0; // of the targets; 0 if there are none
  Viewport Picture;
  GlesProjection Projection{};
  GLint Before = 0; // the framebuffer that was bound before
};

}
