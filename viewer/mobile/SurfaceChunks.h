// SPDX-License-Identifier: BSD-3-Clause
// Cuts a surface into what the graphics memory holds: chunks with 16-bit indices. Step "render" of
// the pipeline picture. No OpenGL here.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/tree/KdTree.h"
#include "viewer/session/look/Coloring.h"
#include "viewer/session/look/VertexNormals.h"

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
  std::uint32_t normal;      // that it had, as in ChunkVertex; the uppermost number is 1
};

struct SurfaceChunk
{
  // The index 65,535 is left out: in WebGL 2 it always means that a strip starts anew.
  static constexpr std::size_t mostVertices = 65535;

  std::vector<ChunkVertex> vertices;
  // Red, green, blue, 255: one a vertex; none for plain stone. The model's own go over smoothly
  // from corner to corner; of those of partitions and resolutions the last corner of a triangle has
  // the triangle's, so "flat" interpolation colours it.
  std::vector<std::array<std::uint8_t, 4>> colors;
  std::vector<std::uint16_t> indices;    // 3 a triangle; none for a cloud
  std::vector<float> radii;              // of a cloud's splats, scaled: one a vertex
  std::vector<GeomorphVertex> geomorphs; // one a vertex; none where nothing morphs
  // Where in its texture each vertex lies, 0-1 from the first row of the first texel; none where
  // nothing paints it.
  std::vector<std::array<float, 2>> places;
};

// Hands out the chunks of a surface one after the other, so that never more than one is held.
//
// Triangles are taken in their order, and each chunk holds as many as have at most 65,535 vertices
// together: a vertex is repeated in every chunk that has a triangle of it. Of a surface that
// DrawSurface has put in order, piece by piece, few are: 1.4 % of the
// Stanford dragon's 437,645 (4.7 % in the order of its file). A cloud repeats none; vertices
// without triangles on a surface that has some are left out. A surface of at most 65,535 points, as
// nearly every part is, becomes one chunk as it stands, such points with it.
//
// Colours cost 4 bytes a vertex and no repeated vertices: of a partition or a resolution, a
// triangle has the colour of one of its corners (SceneRules.h), and is turned until that corner is
// the last.
//
// Complexity O(points + triangles); memory 16 bytes a point beside the chunk, 40 for a moment at
// first.
class ChunkCutter
{
public:
  // The surface, the radii and the coloring must outlive the cutter. Coordinates become (point -
  // center) × scale. REQUIRES: CheckSurface(surface, center) has found nothing. normals: one a
  // point, or none at all. radii: of a cloud's splats, one a point; else none.
  ChunkCutter(const Surface& surface, UnitNormals normals, std::span<const float> radii,
    const TreeDepths& depths, const Coloring& coloring, const Vec3& center, double scale);

  // In the model's unit, of a cloud's splats; 0 for a surface.
  double LargestRadius() const;

  // From where the points morph: one a point, kept as long as the surface. A surface that does not
  // become one chunk as it stands does not morph.
  void SetGeomorph(const PartGeomorph& geomorph);

  // By what the triangles are painted: corners as SurfacePart has them. Both are kept as long as
  // the surface. A vertex that lies in two places of the tile is repeated. A surface that does not
  // become one chunk so is not painted, nor is one whose corners the tile does not have.
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
  const Attribute* OfPoints = nullptr; // ColoredBy: where the colours are those of points
  bool ColoredBySource = false;        // or those of partitions or resolutions
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
