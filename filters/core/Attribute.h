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
std::size_t SizeOf(AttributeType type);
// "int8", "uint8", … "float32", "float64": as stores, servers and messages name them.
std::string_view NameOf(AttributeType type);

enum class AttributeAssociation : std::uint8_t
{
  Point = 0, // a tuple for each vertex
  Cell = 1   // a tuple for each triangle
};

// What an attribute is, without its values.
struct AttributeInfo
{
  std::string name;
  AttributeType type = AttributeType::Float32;
  AttributeAssociation association = AttributeAssociation::Point;
  std::uint8_t components = 1;
  bool operator==(const AttributeInfo&) const = default;

  std::size_t TupleSize() const { return this->components * SizeOf(this->type); } // bytes
};

// What an attribute means to us. By its name, type and components, as VTK's readers name them.
enum class AttributeRole
{
  Other,
  Normals,           // "Normals", three floats or doubles, a point array
  Colors,            // "RGB" or "RGBA", three or four uint8, a point array
  TextureCoordinates // "TCoords", two floats or doubles, a point array
};
AttributeRole RoleOf(const AttributeInfo& attribute);

// Whether viewers may colour by the array: a point array of one component that is not VTK's own
// (whose names begin with "vtk").
bool IsScalar(const AttributeInfo& attribute);
// Whether the values are classes, which have no mean: integers of one byte, and all arrays whose
// name contains "class" or "label" (classification, scalar_Classification, …). Arrays called
// intensity, reflectance, quality, confidence, grey or alpha never are.
bool HoldsClasses(const AttributeInfo& scalar);

// The most arrays that are numbers (IsScalar) which levels carry: the first ones.
inline constexpr std::size_t mostScalars = 16;
// The arrays that levels have too, in their order: normals, colours and numbers, as means, and
// classes, as the most frequent (LevelAttributes.h). O(attributes).
std::vector<AttributeInfo> ArraysOfLevels(std::span<const AttributeInfo> attributes);

// Texture coordinates and material of triangles, on their way through a build: for a triangle's
// three corners six floats, and a uint32 for the material. Stores do not have them: they become
// textures of partitions (filters/build/PieceTextures.h).
inline constexpr std::string_view textureCornersName = "kdstream.corners";
inline constexpr std::string_view textureMaterialName = "kdstream.material";
bool IsTextureArray(const AttributeInfo& attribute);
// Whether the values of a tuple are of the triangle's corners, in their order: they turn with them.
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

// The most that meshes and pieces hold, and the longest name in bytes.
inline constexpr std::size_t mostAttributes = 255;
inline constexpr std::size_t longestAttributeName = 255;

// The first array with this role, or null.
const Attribute* FindRole(std::span<const Attribute> attributes, AttributeRole role);
// The array of that description, or null.
const Attribute* FindAttribute(
  std::span<const Attribute> attributes, const AttributeInfo& description);

// Errors: InvalidInput, naming the array: more than mostAttributes; an empty name, or one of more
// than longestAttributeName bytes; two point arrays, or two cell arrays, of one name; no
// components; bytes that are not one tuple for each of `points` or `cells`.
Status CheckAttributes(
  std::span<const Attribute> attributes, std::size_t points, std::size_t cells);

// Whether a mesh may be stored with an array of that name: 1 to longestAttributeName bytes of UTF-8
// without control characters, because metadata and messages are texts.
bool IsAttributeName(std::string_view name);

// Whether the values are ids, as VTK's attributes GlobalIds and PedigreeIds: integers of one
// component, and named so. Levels do not have them, because they merge what ids tell apart. Not for
// colouring (IsScalar).
bool HoldsIds(const AttributeInfo& attribute);

}
