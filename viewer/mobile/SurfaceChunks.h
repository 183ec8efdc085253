// SPDX-License-Identifier: BSD-3-Clause
// Divides a surface into chunks with 16-bit indices for graphics memory. Step "render" of the
// pipeline picture. No OpenGL is used here.
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

// A vertex of 16 bytes; coordinates are relative to a center, then scaled.
struct ChunkVertex
{
  std::array<float, 3> position;
  std::uint32_t normal; // x, y, z as signed 10-bit numbers, lowest bits first; 511 is 1
};

// Where a vertex morphs from, in 16 bytes.
struct GeomorphVertex
{
  std::array<float, 3> away; // from the vertex's place to the place it morphs from, scaled
  std::uint32_t normal;      // the earlier normal, as in ChunkVertex; the last component is 1
};

struct SurfaceChunk
{
  // The index 65,535 is not used, because WebGL 2 always takes it as the start of a new strip.
  static constexpr std::size_t mostVertices = 65535;

  std::vector<ChunkVertex> vertices;
  // Red, green, blue, 255 for each vertex; empty for plain stone. The model's own colours are
  // interpolated between corners. For partitions and resolutions, the last corner of a triangle has
  // the triangle's colour, and interpolation is "flat".
  std::vector<std::array<std::uint8_t, 4>> colors;
  std::vector<std::uint16_t> indices;    // 3 per triangle; empty for a cloud
  std::vector<float> radii;              // of a cloud's splats, scaled: one per vertex
  std::vector<GeomorphVertex> geomorphs; // one per vertex; empty if nothing morphs
  // Texture coordinates of each vertex: 0-1, where 0 is the edge of the first row or column; empty
  // without a texture.
  std::vector<std::array<float, 2>> places;
};

// Returns the chunks of a surface one after another, so that only one is in memory at a time.
//
// Triangles are taken in order; a chunk gets triangles until they use 65,535 vertices together. A
// vertex is repeated in every chunk that has one of its triangles. DrawSurface orders surfaces
// piece by piece, so few vertices are repeated: 1.4 % of the Stanford dragon's 437,645 (4.7 % in
// the order of its file). Vertices of a cloud are never repeated. On a surface with triangles,
// vertices without triangles are left out. Exception: a surface of at most 65,535 points, as nearly
// every part has, becomes one chunk without changes, and keeps these points.
//
// Colours cost 4 bytes per vertex, and no repeated vertices: a triangle coloured by partition or
// resolution has the colour of one of its corners (SceneRules.h), and is rotated so that this
// corner is the last.
//
// Complexity: O(points + triangles). Memory: 16 bytes per point in addition to the chunk; 40 for a
// moment at the beginning.
class ChunkCutter
{
public:
  // The surface, the radii and the colouring must outlive the cutter. Coordinates become (point -
  // center) × scale. REQUIRES: CheckSurface(surface, center) has found no error. normals: one for
  // each point, or none. radii: of a cloud's splats, one for each point; otherwise none.
  ChunkCutter(const Surface& surface, UnitNormals normals, std::span<const float> radii,
    const TreeDepths& depths, const Coloring& coloring, const Vec3& center, double scale);

  // The largest radius of a cloud's splats, in the model's unit; 0 for a surface.
  double LargestRadius() const;

  // Sets the places from which the points morph: one for each point. They must live as long as the
  // surface. A surface only morphs if it becomes one chunk without changes.
  void SetGeomorph(const PartGeomorph& geomorph);

  // Sets the texture corners of the triangles, as in SurfacePart. Both arguments must live as long
  // as the surface. A vertex with two places in the tile is repeated. A surface is only textured if
  // it still becomes one chunk, and if the tile has all its corners.
  void SetTexturedCorners(std::span<const std::uint32_t> corners, const TextureTile& tile);

  // Replaces `chunk` with the next one; returns false if there is none.
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
  UnitNormals ParentNormals; // of Geomorph
  std::span<const std::uint32_t> Corners;
  const TextureTile* Tile = nullptr;
  std::vector<std::uint32_t> IndexInChunk; // of each point; `absent` if it is not in the chunk yet
  std::size_t Done = 0;                    // triangles, or points of a cloud
};

}
