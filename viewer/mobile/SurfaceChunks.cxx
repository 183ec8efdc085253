// SPDX-License-Identifier: BSD-3-Clause
// Divides a surface into chunks with 16-bit indices: see SurfaceChunks.h.
#include "viewer/mobile/SurfaceChunks.h"

#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/SceneRules.h"
#include "viewer/session/texture/TexturedCorners.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::uint32_t absent = std::numeric_limits<std::uint32_t>::max();

std::uint32_t PackNormal(const std::array<float, 3>& normal)
{
  std::uint32_t packed = 0;
  for (unsigned k = 0; k < 3; ++k)
  {
    const float scaled = normal[k] * 511.0f;
    const auto rounded = static_cast<std::int32_t>(scaled + (scaled < 0.0f ? -0.5f : 0.5f));
    packed |= (static_cast<std::uint32_t>(rounded) & 1023u) << (10 * k);
  }
  return packed;
}

}

ChunkCutter::ChunkCutter(const Surface& surface, UnitNormals normals, std::span<const float> radii,
  const TreeDepths& depths, const Coloring& coloring, const Vec3& center, double scale)
  : Drawn(surface)
  , Depths(depths)
  , Colors(coloring)
  , Center(center)
  , Scale(scale)
  , Normals(std::move(normals))
  , Radii(radii)
{
  this->OfPoints = ColoredBy(surface, coloring);
  this->ColoredBySource =
    coloring.kind == SurfaceColoring::Partition || coloring.kind == SurfaceColoring::Resolution;
  if (!surface.triangles.empty() && surface.points.size() > SurfaceChunk::mostVertices)
  {
    this->IndexInChunk.assign(surface.points.size(), absent);
  }
}

double ChunkCutter::LargestRadius() const
{
  return this->Radii.empty() ? 0.0 : *std::max_element(this->Radii.begin(), this->Radii.end());
}

void ChunkCutter::Append(SurfaceChunk& chunk, VertexId vertex) const
{
  const Vec3 p = (this->Drawn.points[vertex] - this->Center) * this->Scale;
  chunk.vertices.push_back(
    { { static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]) },
      this->Normals.empty() ? 0 : PackNormal(this->Normals[vertex]) });
  if (this->OfPoints || this->ColoredBySource)
  {
    const Color color =
      this->OfPoints
        ? PointColor(*this->OfPoints, this->Colors, vertex)
        : ColorOf(ColorSourceOf(this->Drawn.sources[vertex], this->Depths), this->Colors.kind);
    chunk.colors.push_back({ color[0], color[1], color[2], 255 });
  }
}

bool ChunkCutter::NextOfCloud(SurfaceChunk& chunk)
{
  const std::size_t end =
    std::min(this->Drawn.points.size(), this->Done + SurfaceChunk::mostVertices);
  for (; this->Done < end; ++this->Done)
  {
    this->Append(chunk, static_cast<VertexId>(this->Done));
    chunk.radii.push_back(static_cast<float>(this->Radii[this->Done] * this->Scale));
  }
  return !chunk.vertices.empty();
}

// Puts the whole surface into one chunk, if it fits, as it does for every part of an ordinary
// model.
bool ChunkCutter::NextOfFew(SurfaceChunk& chunk)
{
  if (this->Done > 0)
  {
    return false;
  }
  chunk.vertices.reserve(this->Drawn.points.size());
  for (VertexId v = 0; v < this->Drawn.points.size(); ++v)
  {
    this->Append(chunk, v);
    this->AppendGeomorph(chunk, v);
  }
  chunk.indices.reserve(3 * this->Drawn.triangles.size());
  for (const Triangle& t : this->Drawn.triangles)
  {
    for (const VertexId corner : this->ColoredBySource ? this->WithColorLast(t) : t)
    {
      chunk.indices.push_back(static_cast<std::uint16_t>(corner));
    }
  }
  this->Done = this->Drawn.triangles.size();
  return true;
}

// As NextOfFew, but a point has a vertex for each of its places in the tile. Returns false if these
// are too many; then the chunk stays empty, as Next has made it.
bool ChunkCutter::NextOfTextured(SurfaceChunk& chunk)
{
  const TexturedCorners textured = TexturedCornersOf(this->Drawn, this->Corners, *this->Tile);
  if (textured.points.size() > SurfaceChunk::mostVertices)
  {
    return false;
  }
  for (const VertexId point : textured.points)
  {
    this->Append(chunk, point);
    this->AppendGeomorph(chunk, point);
  }
  for (const Triangle& t : textured.triangles)
  {
    for (const VertexId corner : t)
    {
      chunk.indices.push_back(static_cast<std::uint16_t>(corner));
    }
  }
  chunk.places = textured.places;
  this->Done = this->Drawn.triangles.size();
  return true;
}

void ChunkCutter::SetGeomorph(const PartGeomorph& geomorph)
{
  this->Geomorph = &geomorph;
  this->ParentNormals = UnitNormalsOf(geomorph.normals);
}

void ChunkCutter::SetTexturedCorners(
  std::span<const std::uint32_t> corners, const TextureTile& tile)
{
  if (CanTexture(this->Drawn, corners, tile))
  {
    this->Corners = corners;
    this->Tile = &tile;
  }
}

void ChunkCutter::AppendGeomorph(SurfaceChunk& chunk, VertexId v) const
{
  if (!this->Geomorph)
  {
    return;
  }
  const Vec3 away = (this->Geomorph->points[v] - this->Drawn.points[v]) * this->Scale;
  chunk.geomorphs.push_back(
    { { static_cast<float>(away[0]), static_cast<float>(away[1]), static_cast<float>(away[2]) },
      PackNormal(this->ParentNormals[v]) | 1U << 30 });
}

// The triangle is rotated, not mirrored, so its orientation stays.
Triangle ChunkCutter::WithColorLast(const Triangle& t) const
{
  const auto sourceOf = [this](VertexId v)
  { return ColorSourceOf(this->Drawn.sources[v], this->Depths); };
  const std::array<ColorSource, 3> corners{ sourceOf(t[0]), sourceOf(t[1]), sourceOf(t[2]) };
  const ColorSource whole = Together(Together(corners[0], corners[1]), corners[2]);
  const auto decides = [&](const ColorSource& corner)
  {
    return this->Colors.kind == SurfaceColoring::Partition ? corner.partition == whole.partition
                                                           : corner.resolution == whole.resolution;
  };
  if (decides(corners[2]))
  {
    return t;
  }
  return decides(corners[0]) ? Triangle{ t[1], t[2], t[0] } : Triangle{ t[2], t[0], t[1] };
}

bool ChunkCutter::Next(SurfaceChunk& chunk)
{
  chunk.vertices.clear();
  chunk.colors.clear();
  chunk.indices.clear();
  chunk.radii.clear();
  chunk.geomorphs.clear();
  chunk.places.clear();
  if (this->Drawn.triangles.empty())
  {
    return this->NextOfCloud(chunk);
  }
  if (this->Drawn.points.size() <= SurfaceChunk::mostVertices)
  {
    if (this->Tile && this->Done == 0 && this->NextOfTextured(chunk))
    {
      return true;
    }
    return this->NextOfFew(chunk);
  }
  std::vector<VertexId> taken;
  for (; this->Done < this->Drawn.triangles.size(); ++this->Done)
  {
    if (chunk.vertices.size() + 3 > SurfaceChunk::mostVertices)
    {
      break;
    }
    Triangle triangle = this->Drawn.triangles[this->Done];
    if (this->ColoredBySource)
    {
      triangle = this->WithColorLast(triangle);
    }
    for (const VertexId vertex : triangle)
    {
      std::uint32_t& index = this->IndexInChunk[vertex];
      if (index == absent)
      {
        index = static_cast<std::uint32_t>(chunk.vertices.size());
        taken.push_back(vertex);
        this->Append(chunk, vertex);
      }
      chunk.indices.push_back(static_cast<std::uint16_t>(index));
    }
  }
  for (const VertexId vertex : taken)
  {
    this->IndexInChunk[vertex] = absent;
  }
  return !chunk.indices.empty();
}

}
