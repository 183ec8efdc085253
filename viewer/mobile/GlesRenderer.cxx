// SPDX-License-Identifier: BSD-3-Clause
// Draws a session's scene with OpenGL ES 3.0: see GlesRenderer.h.
#include "viewer/mobile/GlesRenderer.h"

#include "viewer/mobile/GlesChunk.h"
#include "viewer/mobile/GlesOcclusion.h"
#include "viewer/mobile/GlesPrograms.h"
#include "viewer/mobile/SurfaceChunks.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/look/OcclusionShaders.h"
#include "viewer/session/look/SceneLook.h"
#include "viewer/session/look/SceneRules.h"
#include "viewer/session/look/SplatRadii.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

namespace kdstream
{

struct GlesRenderer::Part
{
  DrawnSurface::Part drawn;                  // nothing of a cloud, whose splats depend on all of it
  const Surface* surface = nullptr;          // while it is uploaded,
  std::span<const float> radii;              // and so long of a cloud
  Box bounds;                                // relative to Center, not scaled
  std::shared_ptr<const TextureTile> tile{}; // that paints it; or null
  GLuint texture = 0;                        // of its picture
  std::vector<GlesChunk> chunks;
};

namespace
{

GlesRenderer::TileUpload uploadTile = nullptr;

// With one texel of no colour. Charts have a margin that is enough for halves and quarters.
GLuint MakeTexture()
{
  constexpr std::array<std::uint8_t, 4> nothing{};
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, nothing.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  return texture;
}

// Clears errors of other code. A lost context may report its error for ever.
void ClearErrors()
{
  for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; ++i)
  {
  }
}

// Whether all that was uploaded since ClearErrors is there.
Status CheckUpload(const DrawnSurface& surface)
{
  const GLenum code = glGetError();
  if (code == GL_NO_ERROR)
  {
    return {};
  }
  const std::string size = std::to_string(surface.PointCount()) + " points and " +
                           std::to_string(surface.TriangleCount()) + " triangles";
  return code == GL_OUT_OF_MEMORY
           ? Error{ ErrorCode::LimitExceeded,
               "the graphics memory does not hold a surface of " + size }
           : Error{ ErrorCode::Unsupported,
               "OpenGL ES refuses a surface of " + size + ": error " + std::to_string(code) };
}

template <class Part>
void FreeChunks(const Part& part)
{
  std::for_each(part.chunks.begin(), part.chunks.end(), FreeChunk);
}

template <class Part>
void FreeTexture(const Part& part)
{
  if (part.texture != 0)
  {
    glDeleteTextures(1, &part.texture);
  }
}

// The power of two that brings a length to 0.5 … 1: exact, and so floats round as they would
// without it, while squares of the coordinates of tiny or huge models stay in their range.
double ScaleOf(const Box& bounds)
{
  double largest = 0.0;
  for (std::size_t k = 0; k < 3 && !bounds.Empty(); ++k)
  {
    largest = std::max({ largest, std::abs(bounds.lo[k]), std::abs(bounds.hi[k]) });
  }
  int exponent = 0;
  std::frexp(largest, &exponent);
  return std::ldexp(1.0, -std::max(exponent, -1000));
}

// The tangent of x in 0 … pi / 2 as Lambert's continued fraction. The library's would bring its
// reduction of huge arguments along, which a page has to load.
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

GlesRenderer::~GlesRenderer()
{
  this->Free();
}

Result<std::unique_ptr<GlesRenderer>> GlesRenderer::Make()
{
  std::unique_ptr<GlesRenderer> made(new GlesRenderer);
  auto compiled = GlesPrograms::Make();
  KDSTREAM_TRY(compiled);
  made->Compiled = std::move(*compiled);
  return made;
}

void GlesRenderer::Free()
{
  std::for_each(this->Parts.begin(), this->Parts.end(), FreeChunks<Part>);
  std::for_each(this->Parts.begin(), this->Parts.end(), FreeTexture<Part>);
  this->Parts.clear();
  this->Tried.reset();
  this->FreeCap();
}

void GlesRenderer::SetTileUpload(TileUpload upload)
{
  uploadTile = upload;
}

// Takes over the textures of tiles that paint parts still, lets go of the others, and then has
// those brought that are new.
void GlesRenderer::FollowTiles(std::vector<Part>& parts)
{
  for (Part& part : parts)
  {
    const auto before = std::find_if(this->Parts.begin(), this->Parts.end(),
      [&part](const Part& each) { return part.tile && each.tile == part.tile; });
    part.texture = before == this->Parts.end() ? 0 : std::exchange(before->texture, 0);
  }
  std::for_each(this->Parts.begin(), this->Parts.end(), FreeTexture<Part>);
  for (Part& part : parts)
  {
    if (part.tile && part.texture == 0)
    {
      part.texture = MakeTexture();
      uploadTile(part.texture, *part.tile);
    }
  }
}

// What paints a part, or null.
std::shared_ptr<const TextureTile> GlesRenderer::TileOf(
  const ViewerScene& scene, const SurfacePart& part) const
{
  if (!uploadTile || !scene.tiles || this->Colors.kind != SurfaceColoring::Own)
  {
    return nullptr;
  }
  return FindTile(*scene.tiles, part.piece);
}

void GlesRenderer::FreeCap()
{
  std::for_each(this->Cap.begin(), this->Cap.end(), FreeChunk);
  this->Cap.clear();
  this->CapHere = {};
}

void GlesRenderer::Forget()
{
  if (this->Compiled)
  {
    this->Compiled->Forget();
  }
  this->Cap.clear();
  this->CapHere = {};
  if (this->Occlusion)
  {
    this->Occlusion->Forget();
    this->Occlusion.reset();
  }
  this->Compiled.reset();
  this->Parts.clear();
  this->Tried.reset();
  this->LongestWay.reset();
}

std::size_t GlesRenderer::GraphicsBytes() const
{
  std::size_t bytes = this->Occlusion ? this->Occlusion->Bytes() : 0;
  const auto add = [&bytes](const GlesChunk& chunk) { bytes += chunk.bytes; };
  for (const Part& part : this->Parts)
  {
    std::for_each(part.chunks.begin(), part.chunks.end(), add);
  }
  std::for_each(this->Cap.begin(), this->Cap.end(), add);
  for (const Part& part : this->Parts)
  {
    bytes += part.texture == 0 ? 0 : std::size_t{ 4 } * part.tile->width * part.tile->height;
  }
  return bytes;
}

void GlesRenderer::SetColoring(const Coloring& coloring)
{
  if (!(coloring == this->Colors))
  {
    this->Colors = coloring;
    ++this->ColorsVersion;
  }
}

void GlesRenderer::SetGlided(double share)
{
  this->Glided = share;
}

void GlesRenderer::StopGliding()
{
  for (Part& part : this->Parts)
  {
    std::for_each(part.chunks.begin(), part.chunks.end(), StopGlidingOf);
  }
  this->LongestWay.reset();
}

void GlesRenderer::SetBackground(const Vec3& bottom, const Vec3& top)
{
  this->Bottom = bottom;
  this->Top = top;
}

// Makes the parts of the scene's surface the drawn ones. What is in the graphics memory already
// stays there; what is not needed is freed before anything is uploaded.
Status GlesRenderer::Upload(const ViewerScene& scene)
{
  const bool isCloud = scene.surface->TriangleCount() == 0 && scene.surface->PointCount() > 0;
  const std::vector<float> radii = isCloud ? SplatRadii(*scene.surface) : std::vector<float>();
  std::size_t points = 0;
  std::vector<Part> parts;
  for (const DrawnSurface::Part& drawn : scene.surface->Parts())
  {
    const Surface& surface = drawn.part->surface;
    if (isCloud)
    {
      parts.push_back({ {}, &surface, {}, {}, {}, 0, {} });
      parts.back().radii = std::span(radii).subspan(points, surface.points.size());
      points += surface.points.size();
    }
    else if (!surface.triangles.empty())
    {
      parts.push_back({ drawn, &surface, {}, {}, this->TileOf(scene, *drawn.part), 0, {} });
    }
  }
  this->StopGliding();
  KDSTREAM_TRY(this->Place(scene, parts));
  std::for_each(this->Parts.begin(), this->Parts.end(), FreeChunks<Part>);
  this->FollowTiles(parts);
  this->Parts = std::move(parts);
  ClearErrors();
  std::size_t unchecked = 0; // points
  for (Part& part : this->Parts)
  {
    if (part.chunks.empty())
    {
      this->UploadPart(part);
      unchecked += part.surface->points.size();
    }
    part.surface = nullptr;
    part.radii = {};
    part.drawn.glide = nullptr;
    // Not after each part, since in a browser asking for errors waits for the graphics process.
    if (unchecked >= SurfaceChunk::mostVertices || &part == &this->Parts.back())
    {
      unchecked = 0;
      if (Status status = CheckUpload(*scene.surface); !status)
      {
        this->Free();
        return status;
      }
    }
  }
  this->Bounds = {};
  for (const Part& part : this->Parts)
  {
    this->Bounds.Add(part.bounds);
  }
  this->Facet = FacetLength(*scene.surface);
  return {};
}

// Finds what all of it is drawn by, and takes over the chunks that stay as they are. Errors: those
// of CheckSurface, before anything has changed.
Status GlesRenderer::Place(const ViewerScene& scene, std::vector<Part>& parts)
{
  const Vec3 center = scene.box.Empty() ? Vec3{} : scene.box.lo * 0.5 + scene.box.hi * 0.5;
  const bool mayStay = center == this->Center && scene.depths == this->Depths;
  const auto findBefore = [&](const Part& part) -> Part*
  {
    const auto place = std::partition_point(this->Parts.begin(), this->Parts.end(),
      [&part](const Part& before)
      {
        return part.drawn.part && before.drawn.part &&
               before.drawn.part->piece < part.drawn.part->piece;
      });
    const bool isSame =
      part.drawn.part && place != this->Parts.end() && place->drawn.part == part.drawn.part;
    return mayStay && isSame ? &*place : nullptr;
  };
  Box bounds;
  for (Part& part : parts)
  {
    const Part* before = findBefore(part);
    if (!before)
    {
      KDSTREAM_TRY(CheckSurface(*part.surface, center));
    }
    part.bounds = before ? before->bounds : BoundsAround(*part.surface, center);
    bounds.Add(part.bounds);
  }
  const double scale = ScaleOf(bounds);
  for (Part& part : parts)
  {
    Part* const before = findBefore(part);
    if (before && before->drawn.LooksLike(part.drawn) && scale == this->Scale &&
        this->ColorsVersion == this->Colored && before->tile == part.tile)
    {
      std::swap(part.chunks, before->chunks);
    }
  }
  this->Center = center;
  this->Scale = scale;
  this->Depths = scene.depths;
  this->Colored = this->ColorsVersion;
  this->Points = scene.surface->TriangleCount() == 0 ? scene.surface->PointCount() : 0;
  return {};
}

void GlesRenderer::UploadPart(Part& part)
{
  ChunkCutter cutter(*part.surface,
    part.drawn.normals ? UnitNormalsOf(*part.drawn.normals) : NormalsOf(*part.surface), part.radii,
    this->Depths, this->Colors, this->Center, this->Scale);
  part.bounds = Enlarged(part.bounds, cutter.LargestRadius());
  if (part.drawn.glide && this->Glided < 1)
  {
    cutter.SetGlide(*part.drawn.glide);
    double longest = this->LongestWay.value_or(0);
    for (std::size_t i = 0; i < part.surface->points.size(); ++i)
    {
      longest = std::max(longest, Length(part.drawn.glide->points[i] - part.surface->points[i]));
    }
    this->LongestWay = longest;
  }
  if (part.tile)
  {
    cutter.SetPaint(part.drawn.part->corners, *part.tile);
  }
  SurfaceChunk content;
  while (cutter.Next(content))
  {
    part.chunks.push_back(UploadChunk(content));
  }
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

// Where a scene is seen from, in the units of the graphics memory.
struct GlesRenderer::Sight
{
  Vec3 eye;             // relative to Center
  Vec3 right, up, back; // unit vectors
  double nearest, farthest;
  double tangent; // of half the vertical field of view
  GlesProjection projection;
};

GlesRenderer::Sight GlesRenderer::SightOf(const SceneCamera& camera, const Viewport& viewport) const
{
  Sight sight{};
  const Vec3 eye = camera.eye - this->Center;
  const ClippingPlanes planes = PlanesAround(
    Enlarged(this->Bounds, this->LongestWay.value_or(0)), eye, camera.focal - this->Center);
  sight.eye = eye * this->Scale;
  sight.back = Normalized(camera.eye - camera.focal);
  sight.right = Normalized(Cross(camera.up, sight.back));
  sight.up = Cross(sight.back, sight.right);
  sight.tangent = Tangent(0.5 * camera.verticalFieldOfView);
  sight.nearest = planes.nearest * this->Scale;
  sight.farthest = planes.farthest * this->Scale;
  const double depth = sight.farthest - sight.nearest;
  sight.projection = { static_cast<float>(viewport.height / (sight.tangent * viewport.width)),
    static_cast<float>(1.0 / sight.tangent),
    static_cast<float>(-(sight.farthest + sight.nearest) / depth),
    static_cast<float>(-2.0 * sight.farthest * sight.nearest / depth) };
  return sight;
}

// What every program that places points has. It is in use then.
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
  glEnable(GL_DEPTH_TEST);
}

// Into the bound framebuffer, `height` pixels high. paints: with textures, where there are any.
void GlesRenderer::DrawChunks(const ViewerScene& scene, const Sight& sight, int height, bool paints)
{
  this->DrawChunksBy(0, scene, sight, height, !paints);
  const bool hasTextures = std::any_of(
    this->Parts.begin(), this->Parts.end(), [](const Part& part) { return part.texture != 0; });
  if (paints && hasTextures)
  {
    this->DrawChunksBy(GlesPrograms::paint, scene, sight, height, false);
  }
  this->DrawCap(sight);
}

// Those that a texture paints, or the others, or all of them without.
void GlesRenderer::DrawChunksBy(
  std::size_t paint, const ViewerScene& scene, const Sight& sight, int height, bool all)
{
  const bool isCloud = this->Points > 0;
  std::size_t kind = paint + (isCloud ? GlesPrograms::cloud : 0);
  kind += scene.section ? GlesPrograms::cut : 0;
  kind += scene.lighting.relief > 0 && !isCloud ? GlesPrograms::relief : 0;
  const auto program = this->Compiled->Surface(kind);
  if (!program)
  {
    this->Outcome = program.GetError();
    return;
  }
  this->Aim(*program, sight);
  SetLook(*program, scene.lighting);
  if (scene.section)
  {
    const SectionPlane& plane = *scene.section;
    glUniform4f(glGetUniformLocation(*program, "section"), static_cast<float>(plane.normal[0]),
      static_cast<float>(plane.normal[1]), static_cast<float>(plane.normal[2]),
      static_cast<float>(plane.Above(this->Center) * this->Scale));
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

  glUniform1f(
    glGetUniformLocation(*program, "smoothness"), this->Colors.IsOfPoints() ? 1.0f : 0.0f);
  glUniform1f(glGetUniformLocation(*program, "toGo"), static_cast<float>(1.0 - this->Glided));
  glVertexAttrib4f(AttributePlace::away, 0.0f, 0.0f, 0.0f, 0.0f);
  glVertexAttrib4f(AttributePlace::formerNormal, 0.0f, 0.0f, 0.0f, 0.0f);
  glVertexAttrib4f(AttributePlace::color, stoneColor[0] / 255.0f, stoneColor[1] / 255.0f,
    stoneColor[2] / 255.0f, 1.0f);
  glActiveTexture(GL_TEXTURE0);
  for (const Part& part : this->Parts)
  {
    for (const GlesChunk& chunk : part.chunks)
    {
      const bool isPainted = chunk.buffers[4] != 0;
      if (!all && isPainted != (paint != 0))
      {
        continue;
      }
      if (paint != 0)
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

// What fills the section, in one colour.
void GlesRenderer::DrawCap(const Sight& sight)
{
  if (this->Cap.empty())
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
  for (const GlesChunk& chunk : this->Cap)
  {
    glBindVertexArray(chunk.vertexArray);
    glDrawElements(GL_TRIANGLES, chunk.count, GL_UNSIGNED_SHORT, nullptr);
  }
}

// Brings the scene's cap to the graphics memory, where it is not there.
void GlesRenderer::FollowCap(const ViewerScene& scene)
{
  const bool hasOne = scene.cap && !scene.cap->triangles.empty() && !this->Parts.empty();
  const CapPlace wanted{ hasOne ? scene.capVersion : 0, this->Center, this->Scale };
  if (wanted == this->CapHere)
  {
    return;
  }
  this->FreeCap();
  this->CapHere = wanted;
  if (!hasOne || !CheckSurface(*scene.cap, this->Center))
  {
    return;
  }
  const UnitNormals unlit(scene.cap->points.size());
  const Coloring plain(SurfaceColoring::Stone);
  ChunkCutter cutter(*scene.cap, unlit, {}, this->Depths, plain, this->Center, this->Scale);
  for (SurfaceChunk content; cutter.Next(content);)
  {
    this->Cap.push_back(UploadChunk(content));
  }
}

// The depths that occlusion follows from; false where the device has none of it.
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
  this->Occlusion->EndDepths(sight.projection, this->Facet * this->Scale);
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
  const Content wanted{ scene.surfaceVersion, this->ColorsVersion, scene.tiles };
  if (this->Tried != wanted)
  {
    this->Outcome = this->Upload(scene);
    this->Tried = wanted;
  }

  if (this->LongestWay && this->Glided >= 1)
  {
    this->StopGliding();
  }
  this->FollowCap(scene);

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
  const Sight sight = this->SightOf(camera, viewport);
  const bool occludes =
    this->HasOcclusion && !this->Parts.empty() && this->DrawDepths(scene, sight, viewport);
  glViewport(0, 0, viewport.width, viewport.height);
  glClear(GL_DEPTH_BUFFER_BIT);
  this->DrawBackground();
  if (!this->Parts.empty())
  {
    this->DrawChunks(scene, sight, viewport.height, true);
  }
  if (occludes)
  {
    glBindVertexArray(this->Compiled->EmptyArray());
    this->Occlusion->Darken();
  }
  glBindVertexArray(0);
  return this->Outcome;
}

}
