// SPDX-License-Identifier: BSD-3-Clause
// Divides a surface into chunks with 16-bit indices for graphics memory. Step "render" of the
// pipeline picture. No OpenGL here.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/tree/KdTree.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/VertexNormals.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// 16 bytes; the coordinates are relative to a center, and scaled.
struct ChunkVertex
{
  std::array<float, 3> position;
  std::uint32_t normal; // x, y, z as signed numbers of 10 bits, from the lowest; 511 is 1
};

// Where a vertex morphs from; 16 bytes.
struct GeomorphVertex
{
  std::array<float, 3> away; // from its place there, scaled
  std::uint32_t normal;      // the earlier normal, as in ChunkVertex; the uppermost component is 1
};

struct SurfaceChunk
{
  // The index 65,535 is left out: in WebGL 2 it always means that a strip starts anew.
  static constexpr std::size_t mostVertices = 65535;

  std::vector<ChunkVertex> vertices;
  // Red, green, blue, 255: one for each vertex; none for plain stone. The model's own colours are
  // interpolated between corners. For partitions and resolutions the last corner of a triangle has
  // the triangle's colour, and interpolation is "flat".
  std::vector<std::array<std::uint8_t, 4>> colors;
  std::vector<std::uint16_t> indices;    // 3 a triangle; none for a cloud
  std::vector<float> radii;              // of a cloud's splats, scaled: one a vertex
  std::vector<GeomorphVertex> geomorphs; // one a vertex; none where nothing morphs
  // Texture coordinates of each vertex, 0-1 from the first row of the first texel; none without a
  // texture.
  std::vector<std::array<float, 2>> places;
};

// Returns the chunks of a surface one after the other, so that only one is in memory.
//
// Triangles are taken in order; a chunk holds as many as use at most 65,535 vertices together. A
// vertex is repeated in every chunk that has one of its triangles. DrawSurface orders surfaces
// piece by piece, so few vertices are repeated: 1.4 % of the Stanford dragon's 437,645 (4.7 % in
// the order of its file). A cloud repeats none. On a surface with triangles, vertices without
// triangles are left out. But a surface of at most 65,535 points, as nearly every part is, becomes
// one chunk without changes, including such points.
//
// Colours cost 4 bytes a vertex and no repeated vertices: a triangle coloured by partition or
// resolution has the colour of one of its corners (SceneRules.h), and is rotated so that this
// corner is the last.
//
// Complexity O(points + triangles); memory 16 bytes a point beside the chunk, 40 for a moment at
// first.
class ChunkCutter
{
public:
  // The surface, the radii and the coloring must outlive the cutter. Coordinates become (point -
  // center) × scale. REQUIRES: CheckSurface(surface, center) has found nothing. normals: one for
  // each point, or none. radii: of a cloud's splats, one for each point; else none.
  ChunkCutter(const Surface& surface, UnitNormals normals, std::span<const float> radii,
    const TreeDepths& depths, const Coloring& coloring, const Vec3& center, double scale);

  // In the model's unit, of a cloud's splats; 0 for a surface.
  double LargestRadius() const;

  // The places from which the points morph: one for each point; must live as long as the surface. A
  // surface morphs only if it becomes one chunk without changes.
  void SetGeomorph(const PartGeomorph& geomorph);

  // The texture corners of the triangles, as in SurfacePart. Both arguments must live as long as
  // the surface. A vertex with two places in the tile is repeated. A surface is textured only if it
  // still becomes one chunk, and if the tile has all its corners.
  void SetTexturedCorners(std::span<const std::uint32_t> corners, const TextureTile& tile);

  // Replaces `chunk` with the next one; false when there is none.
  bool Next(SurfaceChunk& chunk);

private:
  void Append(SurfaceChunk& chunk, VertexId vertex) const;
  bool NextOfCloud(SurfaceChunk& chunk);
  bool NextOfFew(SurfaceChunk& chunk);
  bool NextOfTextured(SurfaceChunk& chunk);
  void AppendGeomorph(SurfaceChunk& chunk, VertexId vertex) const;
  Triangle WithColorLast(const Triangle& triangle) const;

  const Surface& Drawn;
  TreeDepths Depths;
  const Coloring& Colors;
  Vec3 Center;
  double Scale;
  const Attribute* OfPoints = nullptr; // the point array of ColoredBy, if colours come from points
  bool ColoredBySource = false;        // whether colours are those of partitions or resolutions
  UnitNormals Normals;
  std::span<const float> Radii;
  const PartGeomorph* Geomorph = nullptr;
  UnitNormals ParentNormals; // of geomorph
  std::span<const std::uint32_t> Corners;
  const TextureTile* Tile = nullptr;
  std::vector<std::uint32_t> IndexInChunk; // of every point; `absent` if it is in no chunk yet
  std::size_t Done = 0;                    // triangles, or points of a cloud
};

}
