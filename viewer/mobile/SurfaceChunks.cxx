// Cuts a surface into chunks with 16-bit indices: see SurfaceChunks.h.
#include "viewer/mobile/SurfaceChunks.h"

#include "viewer/session/Geometry.h"
#include "viewer/session/SceneRules.h"
#include "viewer/session/VertexNormals.h"

#include <algorithm>
#include <limits>

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

ChunkCutter::ChunkCutter(const Surface& surface, const TreeDepths& depths, SurfaceColoring coloring,
  const Vec3& center, double scale)
  : Drawn(surface)
  , Depths(depths)
  , Coloring(coloring)
  , Center(center)
  , Scale(scale)
{
  if (!surface.triangles.empty())
  {
    this->Normals = ComputeVertexNormals(surface.points, surface.triangles);
    this->IndexInChunk.assign(surface.points.size(), absent);
  }
}

void ChunkCutter::Append(SurfaceChunk& chunk, VertexId vertex) const
{
  const Vec3 p = (this->Drawn.points[vertex] - this->Center) * this->Scale;
  chunk.vertices.push_back(
    { { static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]) },
      this->Normals.empty() ? 0 : PackNormal(this->Normals[vertex]) });
  if (this->Coloring != SurfaceColoring::Stone)
  {
    const Color color =
      ColorOf(ColorSourceOf(this->Drawn.sources[vertex], this->Depths), this->Coloring);
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
  }
  return !chunk.vertices.empty();
}

// Turned, not mirrored: the orientation stays.
Triangle ChunkCutter::WithColorLast(const Triangle& t) const
{
  const auto sourceOf = [this](VertexId v)
  { return ColorSourceOf(this->Drawn.sources[v], this->Depths); };
  const std::array<ColorSource, 3> corners{ sourceOf(t[0]), sourceOf(t[1]), sourceOf(t[2]) };
  const ColorSource whole = Together(Together(corners[0], corners[1]), corners[2]);
  const auto decides = [&](const ColorSource& corner)
  {
    return this->Coloring == SurfaceColoring::Partition ? corner.partition == whole.partition
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
  if (this->Drawn.triangles.empty())
  {
    return this->NextOfCloud(chunk);
  }
  std::vector<VertexId> taken;
  for (; this->Done < this->Drawn.triangles.size(); ++this->Done)
  {
    if (chunk.vertices.size() + 3 > SurfaceChunk::mostVertices)
    {
      break;
    }
    Triangle triangle = this->Drawn.triangles[this->Done];
    if (this->Coloring != SurfaceColoring::Stone)
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
