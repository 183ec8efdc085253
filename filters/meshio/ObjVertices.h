// SPDX-License-Identifier: BSD-3-Clause
// Vertices and faces of an OBJ file whose corners name texture coordinates or normals: a vertex for
// each combination of place, texture coordinate and normal. Part of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/ScratchTable.h"

#include <span>

namespace kdstream
{

// Any corner may name any element, so look-ups need tables, which are on disk. Memory: some 10 MiB,
// whatever the file. Disk: 48 bytes a place, 8 a texture coordinate, 12 a normal, 4 a corner and 4
// a face, 16 a further vertex.
//
// Vertex i is place i with the first combination that a corner makes of it; further combinations
// become further vertices, by first appearance. Each combination is one vertex, unless a place has
// more than 64: welding joins the duplicates.
class ObjVertices
{
public:
  // folder: of the tables; empty: the system's for temporary files.
  explicit ObjVertices(const std::filesystem::path& folder);

  // First all places, texture coordinates and normals, in the order of the file …
  Status AddPlace(const ObjPlace& place);
  Status AddTextureCoordinate(const std::array<float, 2>& values)
  {
    return this->TextureCoordinates.Append(values);
  }
  Status AddNormal(const std::array<float, 3>& values) { return this->Normals.Append(values); }
  // … then all faces. Corners are numbers of vertices, texture coordinates and normals, from 1; 0
  // for no texture coordinate or normal. No corners: a face without triangles. Errors: InputOutput;
  // LimitExceeded for too many vertices.
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
  // A combination, and where the next one of the same place is.
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
  ScratchTable<std::uint32_t> Faces; // of each: the number of its corners, and their vertices
  std::uint64_t NextFace = 0;
};

}
