// SPDX-License-Identifier: BSD-3-Clause
// Draws a session's scene with OpenGL ES 3.0: the phone's renderer. Step "render" of the pipeline
// picture.
//
// The same sources draw natively, in any current context, and in the browser, as WebGL 2. The
// picture is the same as VTK's of the scene (viewer/rendering).
#pragma once

#include "filters/core/Result.h"
#include "viewer/mobile/GlesBuffers.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/SceneRules.h"

#include <cstddef>
#include <memory>

namespace kdstream
{

class GlesOcclusion;
class GlesPrograms;

// Threads: that of the context. A context of OpenGL ES 3.0 or WebGL 2 must be current in every
// call, the destructor included; all of the context's state except the bound framebuffer may
// change.
class GlesRenderer
{
public:
  // Compiles the shaders. Errors: Unsupported if no such context is current, or if a shader does
  // not compile, with the driver's message.
  static Result<std::unique_ptr<GlesRenderer>> Make();
  ~GlesRenderer();
  GlesRenderer(const GlesRenderer&) = delete;
  GlesRenderer& operator=(const GlesRenderer&) = delete;

  // Call this when the context was lost, and its objects with it. The next Draw makes everything
  // anew in the context that is current then.
  void Forget();

  void SetColoring(const Coloring& coloring);
  // Whether ambient occlusion is drawn (viewer/session/appearance/OcclusionShaders.h), from the
  // next Draw on; default: not. It draws the surface a second time, into a quarter of the pixels.
  void SetOcclusion(bool occlusion) { this->HasOcclusion = occlusion; }
  // Red, green, blue (0-1) of the background's gradient.
  void SetBackground(const Vec3& bottom, const Vec3& top);

  // The progress of geomorphs (DrawnSurface::Part) in the next Draw: 0: the new surface looks as
  // the one before it; 1, the default: vertices are at their own places.
  void SetMorphed(double share);

  // A function that loads a tile's picture into the texture bound as GL_TEXTURE_2D, at once or
  // later: as RGB, with alpha 1. Until then the texture has one transparent texel. Null, the
  // default: no textures. One for all renderers.
  using TileUpload = void (*)(unsigned texture, const TextureTile& tile);
  static void SetTileUpload(TileUpload upload);

  // Draws the scene into the lower left of the bound framebuffer, which needs a depth buffer; with
  // several samples a pixel, edges are anti-aliased. The surface is uploaded to graphics memory
  // only if surfaceVersion or the coloring has changed, and then only the parts that differ: 16
  // bytes a vertex (4 more with colours, and in a cloud; 16 more while it morphs), 6 a triangle.
  // Parts that are not drawn any more are freed first. viewport: that of the session.
  //
  // Errors: InvalidArgument for an empty viewport, and those of CheckCamera: nothing is drawn.
  // Those of CheckSurface: the old surface stays. LimitExceeded if the graphics memory is not
  // enough: only the background is drawn. Each Draw returns an error about the surface again, until
  // there is another surface. After Forget also the errors of Make.
  Status Draw(const ViewerScene& scene, const Viewport& viewport);

  // The bytes of all buffers and textures that it holds now. O(parts).
  std::size_t GraphicsBytes() const;

private:
  struct Sight;

  GlesRenderer();
  Sight SightOf(const SceneCamera& camera, const Viewport& viewport) const;
  bool DrawDepths(const ViewerScene& scene, const Sight& sight, const Viewport& viewport);
  void DrawBackground();
  void Aim(unsigned program, const Sight& sight) const;
  void DrawChunks(const ViewerScene& scene, const Sight& sight, int height, bool withTextures);
  void DrawChunksBy(
    std::size_t textured, const ViewerScene& scene, const Sight& sight, int height, bool all);
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
