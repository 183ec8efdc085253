// SPDX-License-Identifier: BSD-3-Clause
// The mesh that a tile in another viewer's format shows of one piece: for tilesets of 3D Tiles,
// exported or served, and for single .glb files.
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

// An additional attribute of each vertex.
struct TileArray
{
  std::string name; // as in the store
  std::size_t components = 1;
  std::vector<float> values;
};

// Whether tiles carry this array: a point array with one to four components, neither normals nor
// colours.
bool IsTileArray(const AttributeInfo& array);
// Whether floats hold all values of the array exactly.
bool IsExactInTiles(const AttributeInfo& array);

using PicturePlace = std::array<float, 2>;

// A mesh that stores all attributes in its vertices, as graphics cards require.
struct TileMesh
{
  std::vector<Vec3> points;
  std::vector<Vec3> normals;                       // of length 1; empty: no normals
  std::vector<std::array<std::uint8_t, 4>> colors; // sRGB; empty: no colours
  // Places in the picture, 0-1, from its upper left corner; empty: no texture.
  std::vector<PicturePlace> places;
  std::vector<TileArray> arrays;
  std::vector<Triangle> triangles;   // empty: a cloud
  std::vector<Triangle> skirts;      // close gaps to neighbours of another level
  std::vector<std::uint8_t> picture; // encoded; empty: none
  TileImage pictureFormat = TileImage::Webp;

  bool Empty() const { return this->triangles.empty() && this->points.empty(); }
};

// The normal of a vertex that is a ghost in other pieces, which have only some of the triangles
// around it. Lists of them are in ascending order of keys.
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
  double skirtDepth = 0;                      // in model units
  std::span<const BorderNormal> borders = {}; // of the whole resolution; empty: not known
};

// The part of its resolution that a piece shows: the triangles for which it is the lowest owner of
// a corner. So each triangle of a level is in exactly one piece. For a cloud, its own points. Empty
// if there are none.
//
// Skirts: a neighbour may show another level, whose triangles end elsewhere. So triangles on the
// border that other pieces show are repeated here, with their outer corners lowered by the skirt's
// depth. In addition, bands hang from the outer edges of the displayed triangles.
//
// texture: of the piece, or null. Normals: the array with this role; if there is none, the sum of
// the area vectors of the triangles around a vertex. REQUIRES: a checked piece, and its texture.
TileMesh CutTileMesh(
  const Piece& piece, const TextureTile* texture, const TileMeshOptions& options);

// Whether CutTileMesh makes triangles from a piece. O(size).
bool ShowsTriangles(const Piece& piece);

// The whole mesh as a tile, without skirts. REQUIRES: as many tuples as points; corners are valid.
TileMesh WholeTileMesh(const Mesh& mesh, bool normals);

}
