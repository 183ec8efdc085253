// SPDX-License-Identifier: BSD-3-Clause
// What a tile of other viewers' formats shows of one piece: for tilesets of 3D Tiles, exported and
// served, and for single .glb files.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Attribute.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// What else each vertex has.
struct TileArray
{
  std::string name; // in the store
  std::size_t components = 1;
  std::vector<float> values;
};

// Arrays that tiles carry: of points, with one to four components, neither normals nor colours.
bool IsTileArray(const AttributeInfo& array);
// Whether floats hold all of its values.
bool IsExactInTiles(const AttributeInfo& array);

using PicturePlace = std::array<float, 2>;

// A mesh that carries everything in its vertices, as graphics cards take them.
struct TileMesh
{
  std::vector<Vec3> points;
  std::vector<Vec3> normals;                       // of length 1; empty: none
  std::vector<std::array<std::uint8_t, 4>> colors; // sRGB; empty: none
  std::vector<PicturePlace> places; // in the picture, 0-1, from its upper left; empty: none
  std::vector<TileArray> arrays;
  std::vector<Triangle> triangles;   // none: a cloud
  std::vector<Triangle> skirts;      // close gaps to neighbours of another level
  std::vector<std::uint8_t> picture; // encoded; empty: none
  TileImage pictureFormat = TileImage::Webp;

  bool Empty() const { return this->triangles.empty() && this->points.empty(); }
};

// The normal of a vertex that is a ghost in other pieces, which have only some of the triangles
// around it. Lists of them have ascending keys.
struct BorderNormal
{
  VertexKey key = 0;
  std::array<float, 3> normal{}; // of length 1, or 0
};
// The border normals of a piece's own vertices. O(size).
std::vector<BorderNormal> BorderNormalsOf(const Piece& piece);

struct TileMeshOptions
{
  bool normals = true;
  double skirtDepth = 0;                      // model units
  std::span<const BorderNormal> borders = {}; // of the whole resolution; empty: not known
};

// The part of its resolution that a piece shows: the triangles of which it is the lowest owner of a
// corner. So each triangle of a level is in exactly one piece. Of a cloud the own points. Empty
// where there are none.
//
// Skirts: a neighbour may show another level, whose triangles end elsewhere. So the triangles on
// the border that other pieces show are here once more, their outer corners lowered by the skirt's
// depth; and bands hang from the outer edges of the triangles that are shown.
//
// texture: of the piece, or null. Normals: the array of that role, else the sum of the areas of
// the triangles around a vertex. REQUIRES: a checked piece, and its texture.
TileMesh CutTileMesh(
  const Piece& piece, const TextureTile* texture, const TileMeshOptions& options);

// Whether CutTileMesh makes triangles of a piece. O(size).
bool ShowsTriangles(const Piece& piece);

// The whole mesh as a tile, without skirts. REQUIRES: as many tuples as points; triangles of its
// points.
TileMesh WholeTileMesh(const Mesh& mesh, bool normals);

}
