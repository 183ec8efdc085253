// SPDX-License-Identifier: BSD-3-Clause
// Draws what GlesBuffers holds of a session's scene, with OpenGL ES 3.0: see GlesRenderer.h.
#include "viewer/mobile/GlesRenderer.h"

#include "viewer/mobile/GlesOcclusion.h"
#include "viewer/mobile/GlesPrograms.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/OcclusionShaders.h"
#include "viewer/session/appearance/SceneAppearance.h"
#include "viewer/session/appearance/SceneRules.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>

namespace kdstream
{

namespace
{

// The tangent of x in 0 … pi / 2, by Lambert's continued fraction. The library's function would
// include code for huge arguments, which a page would have to load.
double Tangent(double x)
{
  double fraction = 31.0;
  for (double odd = 29.0; odd > 0.0; odd -= 2.0)
  {
    fraction = odd - x * x / fraction;
  }
  return x / fraction;
}

}

GlesRenderer::GlesRenderer()
  : Bottom(backgroundBottom)
  , Top(backgroundTop)
{
}

GlesRenderer::~GlesRenderer() = default;

Result<std::unique_ptr<GlesRenderer>> GlesRenderer::Make()
{
  std::unique_ptr<GlesRenderer> made(new GlesRenderer);
  auto compiled = GlesPrograms::Make();
  KDSTREAM_TRY(compiled);
  made->Compiled = std::move(*compiled);
  return made;
}

void GlesRenderer::SetTileUpload(TileUpload upload)
{
  GlesBuffers::SetTileUpload(upload);
}

void GlesRenderer::Forget()
{
  if (this->Compiled)
  {
    this->Compiled->Forget();
  }
  if (this->Occlusion)
  {
    this->Occlusion->Forget();
    this->Occlusion.reset();
  }
  this->Compiled.reset();
  this->Buffers.Forget();
}

std::size_t GlesRenderer::GraphicsBytes() const
{
  return this->Buffers.Bytes() + (this->Occlusion ? this->Occlusion->Bytes() : 0);
}

void GlesRenderer::SetColoring(const Coloring& coloring)
{
  this->Buffers.SetColoring(coloring);
}

void GlesRenderer::SetMorphed(double share)
{
  this->Buffers.SetMorphed(share);
}

void GlesRenderer::SetBackground(const Vec3& bottom, const Vec3& top)
{
  this->Bottom = bottom;
  this->Top = top;
}

void GlesRenderer::DrawBackground()
{
  const GLuint program = this->Compiled->Background();
  glUseProgram(program);
  SetVector(program, "bottom", this->Bottom);
  SetVector(program, "top", this->Top);
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(this->Compiled->EmptyArray());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

// From where a scene is seen, in the units of graphics memory.
struct GlesRenderer::Sight
{
  Vec3 eye;             // relative to the center
  Vec3 right, up, back; // unit vectors
  double nearest, farthest;
  double tangent; // of half the vertical field of view
  GlesProjection projection;
  const GlesOcclusion* occlusion; // null: nothing is darkened
};

GlesRenderer::Sight GlesRenderer::SightOf(const SceneCamera& camera, const Viewport& viewport) const
{
  Sight sight{};
  const auto& [center, scale] = this->Buffers.GetPlacement();
  const Vec3 eye = camera.eye - center;
  const ClippingPlanes planes = PlanesAround(this->Buffers.Reach(), eye, camera.focal - center);
  sight.eye = eye * scale;
  sight.back = Normalized(camera.eye - camera.focal);
  sight.right = Normalized(Cross(camera.up, sight.back));
  sight.up = Cross(sight.back, sight.right);
  sight.tangent = Tangent(0.5 * camera.verticalFieldOfView);
  sight.nearest = planes.nearest * scale;
  sight.farthest = planes.farthest * scale;
  const double depth = sight.farthest - sight.nearest;
  sight.projection = { static_cast<float>(viewport.height / (sight.tangent * viewport.width)),
    static_cast<float>(1.0 / sight.tangent),
    static_cast<float>(-(sight.farthest + sight.nearest) / depth),
    static_cast<float>(-2.0 * sight.farthest * sight.nearest / depth) };
  return sight;
}

// Uses a program, and sets the uniforms that all programs have which project points.
void GlesRenderer::Aim(GLuint program, const Sight& sight) const
{
  glUseProgram(program);
  SetVector(program, "eye", sight.eye);
  std::array<float, 9> turn{}; // column by column
  for (std::size_t k = 0; k < 3; ++k)
  {
    turn[3 * k] = static_cast<float>(sight.right[k]);
    turn[3 * k + 1] = static_cast<float>(sight.up[k]);
    turn[3 * k + 2] = static_cast<float>(sight.back[k]);
  }
  glUniformMatrix3fv(glGetUniformLocation(program, "turn"), 1, GL_FALSE, turn.data());
  const GlesProjection& projection = sight.projection;
  glUniform4f(glGetUniformLocation(program, "projection"), projection[0], projection[1],
    projection[2], projection[3]);
  glUniform4f(glGetUniformLocation(program, "grid"), 0.0f, 0.0f, 0.0f, 0.0f);
  if (sight.occlusion)
  {
    sight.occlusion->Aim(program);
  }
  glEnable(GL_DEPTH_TEST);
}

// Draws into the bound framebuffer, which is `height` pixels high. withTextures: whether parts that
// have a texture are drawn with it.
void GlesRenderer::DrawChunks(
  const ViewerScene& scene, const Sight& sight, int height, bool withTextures)
{
  this->DrawChunksBy(0, scene, sight, height, !withTextures);
  const auto& parts = this->Buffers.Parts();
  const bool hasTextures =
    std::any_of(parts.begin(), parts.end(), [](const auto& part) { return part.texture != 0; });
  if (withTextures && hasTextures)
  {
    this->DrawChunksBy(GlesPrograms::textured, scene, sight, height, false);
  }
  this->DrawCap(sight);
}

// Draws the chunks with a texture, or those without; if `all`, draws all chunks without textures.
void GlesRenderer::DrawChunksBy(
  std::size_t textured, const ViewerScene& scene, const Sight& sight, int height, bool all)
{
  const bool isCloud = this->Buffers.IsCloud();
  std::size_t kind = textured + (isCloud ? GlesPrograms::cloud : 0);
  kind += scene.section ? GlesPrograms::cut : 0;
  kind += scene.lighting.relief > 0 && !isCloud ? GlesPrograms::relief : 0;
  const auto program = this->Compiled->Surface(kind);
  if (!program)
  {
    this->Outcome = program.GetError();
    return;
  }
  this->Aim(*program, sight);
  SetLighting(*program, scene.lighting);
  if (scene.section)
  {
    const SectionPlane& plane = *scene.section;
    const auto& [center, scale] = this->Buffers.GetPlacement();
    glUniform4f(glGetUniformLocation(*program, "section"), static_cast<float>(plane.normal[0]),
      static_cast<float>(plane.normal[1]), static_cast<float>(plane.normal[2]),
      static_cast<float>(plane.Above(center) * scale));
  }
  glUniform2f(glGetUniformLocation(*program, "relief"), static_cast<float>(scene.lighting.relief),
    static_cast<float>(reliefShare * height));
  if (isCloud)
  {
    SetVector(
      *program, "splatPixels", Vec3{ 0.5 * height / sight.tangent, smallestSplat, largestSplat });
    SetVector(*program, "depthRange",
      Vec3{ sight.nearest, sight.farthest, 1.0 / (sight.farthest - sight.nearest) });
  }

  glUniform1f(glGetUniformLocation(*program, "smoothness"),
    this->Buffers.GetColoring().IsOfPoints() ? 1.0f : 0.0f);
  glUniform1f(
    glGetUniformLocation(*program, "toGo"), static_cast<float>(1.0 - this->Buffers.Morphed()));
  glVertexAttrib4f(AttributePlace::away, 0.0f, 0.0f, 0.0f, 0.0f);
  glVertexAttrib4f(AttributePlace::parentNormal, 0.0f, 0.0f, 0.0f, 0.0f);
  glVertexAttrib4f(AttributePlace::color, stoneColor[0] / 255.0f, stoneColor[1] / 255.0f,
    stoneColor[2] / 255.0f, 1.0f);
  glActiveTexture(GL_TEXTURE0);
  for (const GlesBuffers::Part& part : this->Buffers.Parts())
  {
    for (const GlesChunk& chunk : part.chunks)
    {
      const bool isTextured = chunk.buffers[4] != 0;
      if (!all && isTextured != (textured != 0))
      {
        continue;
      }
      if (textured != 0)
      {
        glBindTexture(GL_TEXTURE_2D, part.texture);
      }
      glBindVertexArray(chunk.vertexArray);
      if (isCloud)
      {
        glDrawArrays(GL_POINTS, 0, chunk.count);
      }
      else
      {
        glDrawElements(GL_TRIANGLES, chunk.count, GL_UNSIGNED_SHORT, nullptr);
      }
    }
  }
}

// Draws the section's cap in one colour.
void GlesRenderer::DrawCap(const Sight& sight)
{
  if (this->Buffers.Cap().empty())
  {
    return;
  }
  const auto program = this->Compiled->Cap();
  if (!program)
  {
    this->Outcome = program.GetError();
    return;
  }
  this->Aim(*program, sight);
  glUniform1f(glGetUniformLocation(*program, "toGo"), 0.0f);
  glVertexAttrib4f(
    AttributePlace::color, capColor[0] / 255.0f, capColor[1] / 255.0f, capColor[2] / 255.0f, 1.0f);
  for (const GlesChunk& chunk : this->Buffers.Cap())
  {
    glBindVertexArray(chunk.vertexArray);
    glDrawElements(GL_TRIANGLES, chunk.count, GL_UNSIGNED_SHORT, nullptr);
  }
}

// Draws the depths, and computes the occlusion from them. Returns false if the device cannot.
bool GlesRenderer::DrawDepths(
  const ViewerScene& scene, const Sight& sight, const Viewport& viewport)
{
  if (!this->Occlusion)
  {
    auto made = GlesOcclusion::Make();
    if (!made)
    {
      this->HasOcclusion = false;
      return false;
    }
    this->Occlusion = std::move(*made);
  }
  if (!this->Occlusion->BeginDepths(viewport))
  {
    return false;
  }
  this->DrawChunks(scene, sight, HalfSide(viewport.height), false);
  glBindVertexArray(this->Compiled->EmptyArray());
  this->Occlusion->EndDepths(
    sight.projection, this->Buffers.Facet() * this->Buffers.GetPlacement().scale);
  return true;
}

Status GlesRenderer::Draw(const ViewerScene& scene, const Viewport& viewport)
{
  if (viewport.width < 1 || viewport.height < 1)
  {
    return Error{ ErrorCode::InvalidArgument, "a picture of " + std::to_string(viewport.width) +
                                                " x " + std::to_string(viewport.height) +
                                                " pixels cannot be drawn" };
  }
  const SceneCamera camera{ scene.eye, scene.focal, scene.up, scene.viewAngle };
  KDSTREAM_TRY(CheckCamera(camera));
  if (!this->Compiled)
  {
    auto compiled = GlesPrograms::Make();
    KDSTREAM_TRY(compiled);
    this->Compiled = std::move(*compiled);
  }
  this->Buffers.Follow(scene, this->Outcome);

  constexpr std::array<GLenum, 6> off{ GL_BLEND, GL_CULL_FACE, GL_DITHER, GL_SCISSOR_TEST,
    GL_STENCIL_TEST, GL_POLYGON_OFFSET_FILL };
  for (const GLenum each : off)
  {
    glDisable(each);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  glClearDepthf(1.0f);
  Sight sight = this->SightOf(camera, viewport);
  const bool hasSurface = !this->Buffers.Parts().empty();
  if (this->HasOcclusion && hasSurface && this->DrawDepths(scene, sight, viewport))
  {
    sight.occlusion = this->Occlusion.get();
  }
  glViewport(0, 0, viewport.width, viewport.height);
  glClear(GL_DEPTH_BUFFER_BIT);
  this->DrawBackground();
  if (hasSurface)
  {
    this->DrawChunks(scene, sight, viewport.height, true);
  }
  glBindVertexArray(0);
  return this->Outcome;
}

}
