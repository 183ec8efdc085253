// SPDX-License-Identifier: BSD-3-Clause
// Attributes: the arrays that travel with a mesh's vertices and triangles, such as normals and
// colours.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

enum class AttributeType : std::uint8_t
{
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64
};
// Bytes of a value.
constexpr std::size_t SizeOf(AttributeType type)
{
  constexpr std::size_t sizes[] = { 1, 1, 2, 2, 4, 4, 8, 8, 4, 8 };
  return sizes[static_cast<std::size_t>(type)];
}
constexpr bool IsInteger(AttributeType type)
{
  return type < AttributeType::Float32;
}
// The type's name in stores, servers and messages: "int8", "uint8", … "float32", "float64".
std::string_view NameOf(AttributeType type);

enum class AttributeAssociation : std::uint8_t
{
  Point = 0, // a tuple for each vertex
  Cell = 1   // a tuple for each triangle
};

// Describes an attribute: everything except its values.
struct AttributeInfo
{
  std::string name;
  AttributeType type = AttributeType::Float32;
  AttributeAssociation association = AttributeAssociation::Point;
  std::uint8_t components = 1;
  bool operator==(const AttributeInfo&) const = default;

  std::size_t TupleSize() const { return this->components * SizeOf(this->type); } // bytes
};

// What KdStream uses an attribute for. It is recognised by name, type and number of components; the
// names are those that VTK's readers give.
enum class AttributeRole
{
  Other,
  Normals,           // "Normals", three floats or doubles, a point array
  Colors,            // "RGB" or "RGBA", three or four uint8, a point array
  TextureCoordinates // "TCoords", two floats or doubles, a point array
};
AttributeRole RoleOf(const AttributeInfo& attribute);

// Whether viewers can colour by the array. True for a point array of one component, unless it holds
// ids (HoldsIds) or is VTK's own (its name begins with "vtk").
bool IsScalar(const AttributeInfo& attribute);
// Whether the values are classes, of which a mean makes no sense: integers of one byte, and all
// arrays whose name contains "class" or "label" (classification, scalar_Classification, …). Arrays
// called intensity, reflectance, quality, confidence, grey or alpha never are.
bool HoldsClasses(const AttributeInfo& scalar);

// Levels carry at most this number of scalar arrays (IsScalar): the first ones.
inline constexpr std::size_t mostScalars = 16;
// Those of the mesh's arrays that its levels have too, in the same order. Levels hold means of
// normals, colours and numbers, and the most frequent class (LevelAttributes.h). O(attributes).
std::vector<AttributeInfo> ArraysOfLevels(std::span<const AttributeInfo> attributes);

// Two arrays that carry the texture coordinates and the material of each triangle through a build:
// six floats for the three corners, and a uint32 for the material. Stores do not have these arrays:
// the build turns them into textures of partitions (filters/build/PieceTextures.h).
inline constexpr std::string_view textureCornersName = "kdstream.corners";
inline constexpr std::string_view textureMaterialName = "kdstream.material";
bool IsTextureArray(const AttributeInfo& attribute);
// Whether a tuple holds values for the triangle's three corners, in their order. Code that rotates
// the corners must rotate these values too.
bool IsOfCorners(const AttributeInfo& attribute);

// One array, as little-endian values, tuple after tuple.
struct Attribute : AttributeInfo
{
  std::vector<std::uint8_t> values;
  bool operator==(const Attribute&) const = default;

  const AttributeInfo& Info() const { return *this; }
  std::size_t TupleCount() const
  {
    return this->TupleSize() == 0 ? 0 : this->values.size() / this->TupleSize();
  }
  // One component of a tuple as a double: exact, except for integers beyond 2^53. REQUIRES: tuple <
  // TupleCount(), component < components.
  double Get(std::size_t tuple, std::size_t component) const;
  // Rounds to the nearest value of the type, clamped to its range; NaN becomes 0 in integers.
  void Set(std::size_t tuple, std::size_t component, double value);
  // Appends tuple `tuple` of `from`, bit for bit. REQUIRES: the same type and components.
  void Append(const Attribute& from, std::size_t tuple);
};

// The most attributes of a mesh or a piece, and the longest name of an attribute in bytes.
inline constexpr std::size_t mostAttributes = 255;
inline constexpr std::size_t longestAttributeName = 255;

// The first array with this role, or null.
const Attribute* FindRole(std::span<const Attribute> attributes, AttributeRole role);
// The first array with this description, or null.
const Attribute* FindAttribute(
  std::span<const Attribute> attributes, const AttributeInfo& description);

// Checks the arrays of a mesh with this number of points and cells. Errors: InvalidInput, naming
// the array, if there are more than mostAttributes; if a name is empty or longer than
// longestAttributeName bytes; if two point arrays, or two cell arrays, have the same name; if an
// array has no components, or its bytes are not one tuple for each point or cell.
Status CheckAttributes(
  std::span<const Attribute> attributes, std::size_t points, std::size_t cells);

// Whether a mesh may be stored with an array of that name: 1 to longestAttributeName bytes of UTF-8
// without control characters, because metadata and messages are texts.
bool IsAttributeName(std::string_view name);

// Whether the values are ids: integers of one component, in an array with the name of VTK's
// attribute GlobalIds or PedigreeIds. Levels do not have ids, because they merge vertices that have
// different ids. Viewers do not colour by ids (IsScalar).
bool HoldsIds(const AttributeInfo& attribute);

}
