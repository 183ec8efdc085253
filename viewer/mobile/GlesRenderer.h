// SPDX-License-Identifier: BSD-3-Clause
// Draws a session's scene with OpenGL ES 3.0: the phone's renderer. Step "render" of the pipeline
// picture.
//
// The same source code draws natively, in any current context, and in the browser, as WebGL 2. The
// picture is the same as VTK's picture of the scene (viewer/rendering).
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

// Threads: only the context's thread. A context of OpenGL ES 3.0 or WebGL 2 must be current in
// every call, also for the destructor. Calls may change all of the context's state except the bound
// framebuffer.
class GlesRenderer
{
public:
  // Compiles the shaders. Errors: Unsupported if there is no current context of this kind, or if a
  // shader does not compile, with the driver's message.
  static Result<std::unique_ptr<GlesRenderer>> Make();
  ~GlesRenderer();
  GlesRenderer(const GlesRenderer&) = delete;
  GlesRenderer& operator=(const GlesRenderer&) = delete;

  // Call this when the context was lost with all its objects. The next Draw creates everything
  // again in the context that is current then.
  void Forget();

  void SetColoring(const Coloring& coloring);
  // Whether ambient occlusion is drawn (viewer/session/appearance/OcclusionShaders.h), from the
  // next Draw on; the default is false. With occlusion, the surface is drawn a second time, into a
  // quarter of the pixels.
  void SetOcclusion(bool occlusion) { this->HasOcclusion = occlusion; }
  // Red, green and blue (0-1) of the two ends of the background's gradient.
  void SetBackground(const Vec3& bottom, const Vec3& top);

  // The progress of geomorphs (DrawnSurface::Part) in the next Draw. 0: the new surface looks like
  // the one before it. 1, the default: all vertices are at their own places.
  void SetMorphed(double share);

  // Sets the function that loads a tile's picture into the texture bound as GL_TEXTURE_2D, at once
  // or later, as RGB with alpha 1. Until it is loaded, the texture has one transparent texel. Null,
  // the default, means no textures. There is one function for all renderers.
  using TileUpload = void (*)(unsigned texture, const TextureTile& tile);
  static void SetTileUpload(TileUpload upload);

  // Draws the scene into the lower left corner of the bound framebuffer. The framebuffer needs a
  // depth buffer; with several samples per pixel, edges are anti-aliased. The surface is uploaded
  // to graphics memory only if surfaceVersion or the colouring has changed, and then only the parts
  // that differ: 16 bytes per vertex (4 more with colours, and in a cloud; 16 more while it
  // morphs), 6 per triangle. Parts that are no longer drawn are freed first. viewport: as in the
  // session.
  //
  // Errors: InvalidArgument for an empty viewport, and those of CheckCamera: nothing is drawn.
  // Those of CheckSurface: the old surface stays. LimitExceeded if graphics memory is insufficient:
  // only the background is drawn. Each Draw returns an error about the surface again until there is
  // another surface. After Forget, also the errors of Make.
  Status Draw(const ViewerScene& scene, const Viewport& viewport);

  // The bytes of all buffers and textures that this object holds now. O(parts).
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

  std::unique_ptr<GlesOcclusion> Occlusion; // made when it is first needed
  std::unique_ptr<GlesPrograms> Compiled;   // null: must be compiled in the current context
  Status Outcome;                           // of the last upload, or of drawing since
  bool HasOcclusion = false;
  Vec3 Bottom;
  Vec3 Top;
  GlesBuffers Buffers;
};

}
