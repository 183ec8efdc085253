// SPDX-License-Identifier: BSD-3-Clause
// Vertices of an OBJ file whose corners name texture coordinates or normals: see ObjVertices.h.
#include "filters/meshio/ObjVertices.h"

#include <algorithm>

namespace kdstream
{

namespace
{

// Marks a place that no corner has named so far.
constexpr std::uint32_t unset = noVertex;
// How many combinations of one place are searched. Searching all of them would take too long for a
// place with very many.
constexpr unsigned longestSearch = 64;

}

ObjVertices::ObjVertices(const std::filesystem::path& folder)
  : Places(folder)
  , TextureCoordinates(folder)
  , Normals(folder)
  , Further(folder)
  , Faces(folder)
{
}

Status ObjVertices::AddPlace(const ObjPlace& place)
{
  return this->Places.Append({ place.point, place.color, { unset, unset, 0 } });
}

// Adds a further vertex, which becomes the first to be searched for its place.
Result<VertexId> ObjVertices::AddFurther(const Corner& corner, PlaceRecord owner)
{
  const std::uint64_t number = this->Size();
  if (number >= noVertex - 1)
  {
    return Error{ ErrorCode::LimitExceeded, "more than 4294967294 vertices, with those of the same "
                                            "place but other texture coordinates or normals" };
  }
  const std::uint32_t place = corner[0] - 1;
  Status added = this->Further.Append({ place, { corner[1], corner[2], owner.first.next } });
  if (added)
  {
    owner.first.next = static_cast<std::uint32_t>(this->Further.Size());
    added = this->Places.Set(place, owner);
  }
  return added ? Result<VertexId>(static_cast<VertexId>(number)) : added.GetError();
}

// Finds the vertex of a corner among the combinations of its place, or adds it.
Result<VertexId> ObjVertices::VertexOf(const Corner& corner)
{
  const std::uint32_t place = corner[0] - 1;
  Result<PlaceRecord> owner = this->Places.Get(place);
  KDSTREAM_TRY(owner);
  const auto matches = [&corner](const Combination& other)
  { return other.textureCoordinate == corner[1] && other.normal == corner[2]; };
  if (owner->first.textureCoordinate == unset)
  {
    owner->first = { corner[1], corner[2], 0 };
    KDSTREAM_TRY(this->Places.Set(place, *owner));
  }
  if (matches(owner->first))
  {
    return place;
  }
  std::uint32_t number = owner->first.next;
  for (unsigned looked = 0; number != 0 && looked < longestSearch; ++looked)
  {
    const Result<FurtherRecord> further = this->Further.Get(number - 1);
    KDSTREAM_TRY(further);
    if (matches(further->combination))
    {
      return static_cast<VertexId>(this->Places.Size() + number - 1);
    }
    number = further->combination.next;
  }
  return this->AddFurther(corner, *owner);
}

Status ObjVertices::AddFace(std::span<const Corner> corners)
{
  Status added = this->Faces.Append(static_cast<std::uint32_t>(corners.size()));
  for (const Corner& corner : corners)
  {
    if (!added)
    {
      break;
    }
    const Result<VertexId> vertex = this->VertexOf(corner);
    added = vertex ? this->Faces.Append(*vertex) : vertex.GetError();
  }
  return added;
}

Status ObjVertices::Look(const Combination& combination, Vertex& vertex)
{
  if (combination.textureCoordinate != 0 && combination.textureCoordinate != unset)
  {
    const auto found = this->TextureCoordinates.Get(combination.textureCoordinate - 1);
    KDSTREAM_TRY(found);
    vertex.textureCoordinate = *found;
  }
  if (combination.normal != 0 && combination.normal != unset)
  {
    const auto found = this->Normals.Get(combination.normal - 1);
    KDSTREAM_TRY(found);
    vertex.normal = *found;
  }
  return {};
}

Result<ObjVertices::Vertex> ObjVertices::GetVertex(std::uint64_t index)
{
  std::uint64_t place = index;
  Combination combination;
  const bool isFurther = index >= this->Places.Size();
  if (isFurther)
  {
    const Result<FurtherRecord> further = this->Further.Get(index - this->Places.Size());
    KDSTREAM_TRY(further);
    place = further->place;
    combination = further->combination;
  }
  const Result<PlaceRecord> record = this->Places.Get(place);
  KDSTREAM_TRY(record);
  Vertex vertex;
  vertex.place.point = record->point;
  vertex.place.color = record->color;
  Status looked = this->Look(isFurther ? combination : record->first, vertex);
  return looked ? Result<Vertex>(vertex) : looked.GetError();
}

Result<Vec3> ObjVertices::GetPoint(std::uint64_t index)
{
  if (index >= this->Places.Size())
  {
    const Result<FurtherRecord> further = this->Further.Get(index - this->Places.Size());
    KDSTREAM_TRY(further);
    index = further->place;
  }
  const Result<PlaceRecord> record = this->Places.Get(index);
  KDSTREAM_TRY(record);
  return record->point;
}

Status ObjVertices::ReadFace(std::vector<Triangle>& triangles)
{
  const Result<std::uint32_t> corners = this->Faces.Get(this->NextFace);
  KDSTREAM_TRY(corners);
  Triangle triangle{};
  for (std::uint32_t i = 0; i < *corners; ++i)
  {
    const Result<std::uint32_t> vertex = this->Faces.Get(this->NextFace + 1 + i);
    KDSTREAM_TRY(vertex);
    triangle[std::min<std::uint32_t>(i, 2)] = *vertex;
    if (i >= 2)
    {
      triangles.push_back(triangle);
      triangle[1] = *vertex;
    }
  }
  this->NextFace += 1 + *corners;
  return {};
}

}
