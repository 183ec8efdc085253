// SPDX-License-Identifier: BSD-3-Clause
// Uploads a scene to graphics memory, but only what is not there yet: see GlesBuffers.h.
#include "viewer/mobile/GlesBuffers.h"

#include "viewer/mobile/SurfaceChunks.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/SplatRadii.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

GlesBuffers::TileUpload uploadTile = nullptr;

// Makes a texture with one transparent texel. It uses mipmaps of half and quarter size, for which
// the margins of charts are wide enough.
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

// Clears the errors of other code. A lost context may report its error for ever, so the number of
// tries is limited.
void ClearErrors()
{
  for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; ++i)
  {
  }
}

// Checks that everything that was uploaded since ClearErrors is there.
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
               "the graphics memory is too small for a surface of " + size }
           : Error{ ErrorCode::Unsupported,
               "OpenGL ES refuses a surface of " + size + ": error " + std::to_string(code) };
}

void FreeChunks(const GlesBuffers::Part& part)
{
  std::for_each(part.chunks.begin(), part.chunks.end(), FreeChunk);
}

void FreeTexture(const GlesBuffers::Part& part)
{
  if (part.texture != 0)
  {
    glDeleteTextures(1, &part.texture);
  }
}

// The power of two that brings a length to 0.5 … 1. Multiplying by it is exact, so floats round as
// they would without it; but squares of the coordinates of tiny or huge models do not overflow or
// vanish.
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

}

GlesBuffers::~GlesBuffers()
{
  this->Free();
}

void GlesBuffers::Free()
{
  std::for_each(this->PartList.begin(), this->PartList.end(), FreeChunks);
  std::for_each(this->PartList.begin(), this->PartList.end(), FreeTexture);
  this->PartList.clear();
  this->Tried.reset();
  this->FreeCap();
}

void GlesBuffers::FreeCap()
{
  std::for_each(this->CapChunks.begin(), this->CapChunks.end(), FreeChunk);
  this->CapChunks.clear();
  this->CapHere = {};
}

void GlesBuffers::Forget()
{
  this->CapChunks.clear();
  this->CapHere = {};
  this->PartList.clear();
  this->Tried.reset();
  this->LongestWay.reset();
}

void GlesBuffers::SetTileUpload(TileUpload upload)
{
  uploadTile = upload;
}

void GlesBuffers::SetColoring(const Coloring& coloring)
{
  if (!(coloring == this->Colors))
  {
    this->Colors = coloring;
    ++this->ColorsVersion;
  }
}

std::size_t GlesBuffers::Bytes() const
{
  std::size_t bytes = 0;
  const auto add = [&bytes](const GlesChunk& chunk) { bytes += chunk.bytes; };
  for (const Part& part : this->PartList)
  {
    std::for_each(part.chunks.begin(), part.chunks.end(), add);
    bytes += part.texture == 0 ? 0 : std::size_t{ 4 } * part.tile->width * part.tile->height;
  }
  std::for_each(this->CapChunks.begin(), this->CapChunks.end(), add);
  return bytes;
}

Box GlesBuffers::Reach() const
{
  return Enlarged(this->Bounds, this->LongestWay.value_or(0));
}

void GlesBuffers::StopMorphing()
{
  for (Part& part : this->PartList)
  {
    std::for_each(part.chunks.begin(), part.chunks.end(), StopMorphingOf);
  }
  this->LongestWay.reset();
}

void GlesBuffers::Follow(const ViewerScene& scene, Status& outcome)
{
  const Content wanted{ scene.surfaceVersion, this->ColorsVersion, scene.tiles };
  if (this->Tried != wanted)
  {
    outcome = this->Upload(scene);
    this->Tried = wanted;
  }
  if (this->LongestWay && this->MorphedShare >= 1)
  {
    this->StopMorphing();
  }
  this->FollowCap(scene);
}

// Makes the uploaded parts those of the scene's surface. Existing parts stay; parts that are no
// longer needed are freed before anything is uploaded.
Status GlesBuffers::Upload(const ViewerScene& scene)
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
  this->StopMorphing();
  KDSTREAM_TRY(this->TakeOver(scene, parts));
  std::for_each(this->PartList.begin(), this->PartList.end(), FreeChunks);
  this->FollowTiles(parts);
  this->PartList = std::move(parts);
  ClearErrors();
  std::size_t unchecked = 0; // points
  for (Part& part : this->PartList)
  {
    if (part.chunks.empty())
    {
      this->UploadPart(part);
      unchecked += part.surface->points.size();
    }
    part.surface = nullptr;
    part.radii = {};
    part.drawn.geomorph = nullptr;
    // Errors are not checked after each part, because in a browser this waits for the graphics
    // process.
    if (unchecked >= SurfaceChunk::mostVertices || &part == &this->PartList.back())
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
  for (const Part& part : this->PartList)
  {
    this->Bounds.Add(part.bounds);
  }
  this->FacetOfAll = FacetLength(*scene.surface);
  return {};
}

// Finds the placement for the whole surface, and keeps the chunks that do not change. Errors: those
// of CheckSurface, before anything has changed.
Status GlesBuffers::TakeOver(const ViewerScene& scene, std::vector<Part>& parts)
{
  const Vec3 center = scene.box.Empty() ? Vec3{} : scene.box.lo * 0.5 + scene.box.hi * 0.5;
  const bool mayStay = center == this->Place.center && scene.depths == this->Depths;
  const auto findBefore = [&](const Part& part) -> Part*
  {
    const auto place = std::partition_point(this->PartList.begin(), this->PartList.end(),
      [&part](const Part& before)
      {
        return part.drawn.part && before.drawn.part &&
               before.drawn.part->piece < part.drawn.part->piece;
      });
    const bool isSame =
      part.drawn.part && place != this->PartList.end() && place->drawn.part == part.drawn.part;
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
    if (before && before->drawn.LooksLike(part.drawn) && scale == this->Place.scale &&
        this->ColorsVersion == this->Colored && before->tile == part.tile)
    {
      std::swap(part.chunks, before->chunks);
    }
  }
  this->Place = { center, scale };
  this->Depths = scene.depths;
  this->Colored = this->ColorsVersion;
  this->Points = scene.surface->TriangleCount() == 0 ? scene.surface->PointCount() : 0;
  return {};
}

void GlesBuffers::UploadPart(Part& part)
{
  ChunkCutter cutter(*part.surface,
    part.drawn.normals ? UnitNormalsOf(*part.drawn.normals) : NormalsOf(*part.surface), part.radii,
    this->Depths, this->Colors, this->Place.center, this->Place.scale);
  part.bounds = Enlarged(part.bounds, cutter.LargestRadius());
  if (part.drawn.geomorph && this->MorphedShare < 1)
  {
    cutter.SetGeomorph(*part.drawn.geomorph);
    double longest = this->LongestWay.value_or(0);
    for (std::size_t i = 0; i < part.surface->points.size(); ++i)
    {
      longest = std::max(longest, Length(part.drawn.geomorph->points[i] - part.surface->points[i]));
    }
    this->LongestWay = longest;
  }
  if (part.tile)
  {
    cutter.SetTexturedCorners(part.drawn.part->corners, *part.tile);
  }
  SurfaceChunk content;
  while (cutter.Next(content))
  {
    part.chunks.push_back(UploadChunk(content));
  }
}

// Keeps the textures of tiles that are still used, releases the others, and then requests new
// textures.
void GlesBuffers::FollowTiles(std::vector<Part>& parts)
{
  for (Part& part : parts)
  {
    const auto before = std::find_if(this->PartList.begin(), this->PartList.end(),
      [&part](const Part& each) { return part.tile && each.tile == part.tile; });
    part.texture = before == this->PartList.end() ? 0 : std::exchange(before->texture, 0);
  }
  std::for_each(this->PartList.begin(), this->PartList.end(), FreeTexture);
  for (Part& part : parts)
  {
    if (part.tile && part.texture == 0)
    {
      part.texture = MakeTexture();
      uploadTile(part.texture, *part.tile);
    }
  }
}

// The texture tile of a part, or null.
std::shared_ptr<const TextureTile> GlesBuffers::TileOf(
  const ViewerScene& scene, const SurfacePart& part) const
{
  if (!uploadTile || !scene.tiles || this->Colors.kind != SurfaceColoring::Own)
  {
    return nullptr;
  }
  return FindTile(*scene.tiles, part.piece);
}

// Uploads the scene's cap to graphics memory, unless it is there.
void GlesBuffers::FollowCap(const ViewerScene& scene)
{
  const bool hasOne = scene.cap && !scene.cap->triangles.empty() && !this->PartList.empty();
  const CapPlace wanted{ hasOne ? scene.capVersion : 0, this->Place };
  if (wanted == this->CapHere)
  {
    return;
  }
  this->FreeCap();
  this->CapHere = wanted;
  if (!hasOne || !CheckSurface(*scene.cap, this->Place.center))
  {
    return;
  }
  const UnitNormals unlit(scene.cap->points.size());
  const Coloring plain(SurfaceColoring::Stone);
  ChunkCutter cutter(
    *scene.cap, unlit, {}, this->Depths, plain, this->Place.center, this->Place.scale);
  for (SurfaceChunk content; cutter.Next(content);)
  {
    this->CapChunks.push_back(UploadChunk(content));
  }
}

}
