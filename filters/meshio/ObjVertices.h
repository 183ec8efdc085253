// SPDX-License-Identifier: BSD-3-Clause
// The vertices and faces of an OBJ file whose corners name texture coordinates or normals. Each
// combination of place, texture coordinate and normal is a vertex. Part of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/ScratchTable.h"

#include <span>

namespace kdstream
{

// Any corner may name any element, so look-ups need tables, which are on disk. Memory: about 10
// MiB, whatever the file. Disk: 48 bytes for each place, 8 for a texture coordinate, 12 for a
// normal, 4 for a corner, 4 for a face, and 16 for each further vertex.
//
// A place is a position of the file, a `v` line. Vertex i is place i, with the texture coordinate
// and the normal of the first corner that uses it. Every other combination of a place becomes a
// vertex after these, in order of first appearance. If a place has more than 64 combinations, some
// become several equal vertices, which welding joins.
class ObjVertices
{
public:
  // folder: for the tables; if empty, the system's folder for temporary files.
  explicit ObjVertices(const std::filesystem::path& folder);

  // First all places, texture coordinates and normals, in the order of the file …
  Status AddPlace(const ObjPlace& place);
  Status AddTextureCoordinate(const std::array<float, 2>& values)
  {
    return this->TextureCoordinates.Append(values);
  }
  Status AddNormal(const std::array<float, 3>& values) { return this->Normals.Append(values); }
  // … then all faces. A corner has the numbers of a place, a texture coordinate and a normal,
  // counted from 1; 0 if it has no texture coordinate or normal. A face without corners has no
  // triangles. Errors: InputOutput; LimitExceeded for too many vertices.
  using Corner = std::array<std::uint32_t, 3>;
  Status AddFace(std::span<const Corner> corners);

  std::uint64_t Size() const { return this->Places.Size() + this->Further.Size(); }
  struct Vertex
  {
    ObjPlace place;
    std::array<float, 2> textureCoordinate{};
    std::array<float, 3> normal{};
  };
  // REQUIRES: index < Size().
  Result<Vertex> GetVertex(std::uint64_t index);

  // REQUIRES: index < Size().
  Result<Vec3> GetPoint(std::uint64_t index);

  // Appends the next face as a fan; the faces come in the order in which they were added.
  Status ReadFace(std::vector<Triangle>& triangles);

private:
  // A combination, and a link to the next combination of the same place.
  struct Combination
  {
    std::uint32_t textureCoordinate = 0;
    std::uint32_t normal = 0;
    std::uint32_t next = 0; // number of a further vertex, from 1
  };
  struct PlaceRecord
  {
    Vec3 point{};
    std::array<float, 3> color{};
    Combination first;
  };
  struct FurtherRecord
  {
    std::uint32_t place = 0;
    Combination combination;
  };

  Result<VertexId> VertexOf(const Corner& corner);
  Result<VertexId> AddFurther(const Corner& corner, PlaceRecord owner);
  Status Look(const Combination& combination, Vertex& vertex);

  ScratchTable<PlaceRecord> Places;
  ScratchTable<std::array<float, 2>> TextureCoordinates;
  ScratchTable<std::array<float, 3>> Normals;
  ScratchTable<FurtherRecord> Further;
  ScratchTable<std::uint32_t> Faces; // for each face: the number of corners, then their vertices
  std::uint64_t NextFace = 0;
};

}
