// SPDX-License-Identifier: BSD-3-Clause
// Which scalar properties of a PLY element make up which array, and the names of written arrays.
// Part of steps "read" and of writing.
//
// Joined into one array, wherever they stand in the record:
//   nx ny nz, float or double                                       -> Normals
//   red green blue [alpha], uchar (or diffuse_red …, or r g b [a]),
//   in any case                                                     -> RGB or RGBA
//   u v (or s t, texture_u texture_v), float or double              -> TCoords
//   NAME_0 NAME_1 …, at least two that follow each other, one type  -> NAME
// Every other scalar property is an array of its own name.
// - Colours of other types are arrays like any other, since bytes would lose bits. ShownColors.h
//   adds an array for viewers.
// - PLY has no integers of 64 bits. An array NAME of these is written, and read, as uint
//   NAME_int64_0 NAME_int64_1 … (or _uint64_), low half first. The types int64 and uint64 of some
//   programs are read.
// - Bytes that a property's name cannot have (blanks, control characters), or that would change its
//   meaning, are written as %XX; readers replace %XX by the byte.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/meshio/ply/PlyHeader.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

struct PlyArray
{
  AttributeInfo info;
  std::vector<std::size_t> properties; // their numbers in the element, by component
  PlyType type = PlyType::Float32;     // of each property
};

// The arrays of an element, ordered by first property, at most `most`. Not among them: arrays
// beyond `most`, lists, names that are not valid (IsAttributeName), and duplicate names. taken:
// numbers of properties that are used otherwise (coordinates). O(p log p) for p properties.
std::vector<PlyArray> FindPlyArrays(const PlyElement& element, AttributeAssociation association,
  std::span<const std::size_t> taken, std::size_t most);

// Appends to `element` the properties from which FindPlyArrays makes these arrays again. All arrays
// are of points, or all of cells; their values come in the order of the arrays, component by
// component. REQUIRES: names that IsAttributeName accepts, all different.
void AddPlyProperties(std::span<const Attribute* const> arrays, PlyElement& element);

// Takes the values of one record: gathers them in a row, then appends the row's tuples to the
// attributes. Memory: the attributes, and one row.
class PlyArraySink
{
public:
  struct Column // a property whose value is kept
  {
    std::size_t property = 0;
    std::size_t array = 0;       // number among the arrays
    std::size_t tupleOffset = 0; // bytes
    std::size_t rowOffset = 0;   // bytes
    PlyType type = PlyType::Float32;
  };

  PlyArraySink() = default;
  PlyArraySink(const PlyElement& element, const std::vector<PlyArray>& arrays);

  bool Empty() const { return this->Sizes.empty(); }
  // Where values go from now on: attributes[k] is the k-th array. mostRepeated: see Append.
  void Start(std::span<Attribute> attributes, std::uint64_t mostRepeated)
  {
    this->Attributes = attributes;
    this->MostRepeated = mostRepeated;
  }
  const std::vector<Column>& Columns() const { return this->ColumnList; }

  // Where in the row the value of a property belongs, little-endian; null if it is not kept.
  std::uint8_t* PlaceOf(std::size_t property)
  {
    const std::size_t column = property < this->ColumnOf.size() ? this->ColumnOf[property] : none;
    return column == none ? nullptr : this->Row.data() + this->ColumnList[column].rowOffset;
  }
  // Appends the row as the tuple of `times` points or triangles. False if repeated rows would take
  // more than mostRepeated bytes in all: so a polygon of many corners in a small file cannot fill
  // the memory.
  bool Append(std::size_t times);
  // Room for `count` tuples of array k; returns the first.
  std::uint8_t* Extend(std::size_t array, std::size_t count);
  // The first of the last `count` tuples of array k.
  std::uint8_t* Last(std::size_t array, std::size_t count)
  {
    std::vector<std::uint8_t>& values = this->Attributes[array].values;
    return values.data() + (values.size() - count * this->Sizes[array]);
  }
  std::size_t TupleSize(std::size_t array) const { return this->Sizes[array]; }

private:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  std::vector<Column> ColumnList;
  std::vector<std::size_t> ColumnOf; // by property
  std::vector<std::size_t> Sizes;    // bytes of a tuple
  std::vector<std::uint8_t> Row;
  std::span<Attribute> Attributes;
  std::uint64_t MostRepeated = 0;
  std::uint64_t Repeated = 0;
};

}
