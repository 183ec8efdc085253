// SPDX-License-Identifier: BSD-3-Clause
// Draws a session's scene with OpenGL ES 3.0: the phone's renderer. Step "render" of the pipeline
// picture.
//
// The same sources draw natively, in whatever context is current, and, as WebGL 2, in the browser.
// The picture is VTK's of the same scene (viewer/rendering).
#pragma once

#include "filters/core/Result.h"
#include "viewer/mobile/GlesBuffers.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/look/Coloring.h"
#include "viewer/session/look/SceneRules.h"

#include <cstddef>
#include <memory>

namespace kdstream
{

class GlesOcclusion;
class GlesPrograms;

// Threads: that of the context. A context of OpenGL ES 3.0 or WebGL 2 must be current in every
// call, the destructor included; all of the context's state but the bound framebuffer may change.
class GlesRenderer
{
public:
  // Compiles the shaders. Errors: Unsupported where no such context is current, or a shader is
  // refused, with what the driver says.
  static Result<std::unique_ptr<GlesRenderer>> Make();
  ~GlesRenderer();
  GlesRenderer(const GlesRenderer&) = delete;
  GlesRenderer& operator=(const GlesRenderer&) = delete;

  // The context was lost: its objects are gone. The next Draw makes everything anew in the context
  // that is current then.
  void Forget();

  void SetColoring(const Coloring& coloring);
  // Whether ambient occlusion is drawn (viewer/session/look/OcclusionShaders.h), from the next Draw
  // on; not at first. It draws the surface a second time, into a quarter of the pixels.
  void SetOcclusion(bool occlusion) { this->HasOcclusion = occlusion; }
  // Red, green, blue (0-1) of the gradient behind the model.
  void SetBackground(const Vec3& bottom, const Vec3& top);

  // How far what morphs (DrawnSurface::Part) has come from where it stood in the surface before, in
  // the next Draw: from 0, to 1, which it is at first. At 0 a new surface looks as the one before
  // it.
  void SetMorphed(double share);

  // What brings a tile's picture to a texture that is bound as GL_TEXTURE_2D, at once or later: as
  // RGB, whose alpha is 1. Until then the texture has one texel without colour. Null, as at first:
  // nothing is painted. One for all renderers.
  using TileUpload = void (*)(unsigned texture, const TextureTile& tile);
  static void SetTileUpload(TileUpload upload);

  // Draws the scene into the lower left of the bound framebuffer, which needs a depth buffer; with
  // several samples a pixel, edges are smooth. The surface goes to the graphics memory only where
  // surfaceVersion is another one than last time, or the coloring is, and then only its parts that
  // differ: 16 bytes a vertex (4 more with colours, and in a cloud; 16 more while it morphs),
  // 6 a triangle; what is not drawn any more is freed first. viewport: as that of the session.
  //
  // Errors: InvalidArgument for an empty viewport and those of CheckCamera: nothing is drawn then.
  // Those of CheckSurface: the surface before it stays. LimitExceeded where the graphics memory
  // does not suffice: only the background is drawn. An error about the surface is said again at
  // each Draw until there is another one. Those of Make after Forget.
  Status Draw(const ViewerScene& scene, const Viewport& viewport);

  // Of all buffers and textures that it holds now. O(parts).
  std::size_t GraphicsBytes() const;

private:
  struct Sight;

  GlesRenderer();
  Sight SightOf(const SceneCamera& camera, const Viewport& viewport) const;
  bool DrawDepths(const ViewerScene& scene, const Sight& sight, const Viewport& viewport);
  void DrawBackground();
  void Aim(unsigned program, const Sight& sight) const;
  void DrawChunks(const ViewerScene& scene, const Sight& sight, int height, bool paints);
  void DrawChunksBy(
    std::size_t paint, const ViewerScene& scene, const Sight& sight, int height, bool all);
  void DrawCap(const Sight& sight);

  std::unique_ptr<GlesOcclusion> Occlusion; // made when it is first wanted
  std::unique_ptr<GlesPrograms> Compiled;   // null: to be compiled in the context that is current
  Status Outcome;                           // of the last upload, or of drawing since
  bool HasOcclusion = false;
  Vec3 Bottom;
  Vec3 Top;
  GlesBuffers Buffers;
};

}
