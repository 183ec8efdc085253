// SPDX-License-Identifier: BSD-3-Clause
// Defines which scalar properties of a PLY element make up which array, and under which names
// arrays are written. Part of step "read" and of writing.
//
// Joined into one array, wherever they are in the record:
//   nx ny nz, float or double                                       -> Normals
//   red green blue [alpha], uchar (or diffuse_red …, or r g b [a]),
//   in any case                                                     -> RGB or RGBA
//   u v (or s t, texture_u texture_v), float or double              -> TCoords
//   NAME_0 NAME_1 …, at least two that follow each other, one type  -> NAME
// Every other scalar property is an array of its own, with the property's name.
// - Colours of other types are arrays like any other, since bytes would lose bits. ShownColors.h
//   adds an array for viewers.
// - PLY has no integers of 64 bits. An array NAME of such integers is written, and read, as uint
//   NAME_int64_0 NAME_int64_1 … (or _uint64_), low half first. The types int64 and uint64 that some
//   programs write are read.
// - Bytes that a property's name cannot have (blanks, control characters), or that would change its
//   meaning, are written as %XX; the reader turns %XX back into the byte.
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
  std::vector<std::size_t> properties;         // property numbers in the element, by component
  AttributeType type = AttributeType::Float32; // of each property
};

// Finds the arrays of an element, at most `most`, in the order of their first properties. Skipped:
// arrays beyond `most`, lists, names that are not valid (IsAttributeName), and duplicate names.
// taken: the numbers of properties with another use (coordinates). O(p log p) for p properties.
std::vector<PlyArray> FindPlyArrays(const PlyElement& element, AttributeAssociation association,
  std::span<const std::size_t> taken, std::size_t most);

// Appends to `element` the properties from which FindPlyArrays makes these arrays again. Either all
// arrays belong to points or all to cells. The properties follow the order of the arrays, component
// by component. REQUIRES: names that IsAttributeName accepts, all different.
void AddPlyProperties(std::span<const Attribute* const> arrays, PlyElement& element);

// Collects the values of one record in a row, then appends the row to the attributes, one tuple
// each. Memory: the attributes, and one row.
class PlyArraySink
{
public:
  struct Column // a property whose value is kept
  {
    std::size_t property = 0;
    std::size_t array = 0;       // number of the array
    std::size_t tupleOffset = 0; // bytes
    std::size_t rowOffset = 0;   // bytes
    AttributeType type = AttributeType::Float32;
  };

  PlyArraySink() = default;
  PlyArraySink(const PlyElement& element, const std::vector<PlyArray>& arrays);

  bool Empty() const { return this->Sizes.empty(); }
  // Sets where values go from now on: attributes[k] is array k. mostRepeated: see Append.
  void Start(std::span<Attribute> attributes, std::uint64_t mostRepeated)
  {
    this->Attributes = attributes;
    this->MostRepeated = mostRepeated;
  }
  const std::vector<Column>& Columns() const { return this->ColumnList; }

  // Where in the row the value of this property goes, little-endian; null if it is not kept.
  std::uint8_t* PlaceOf(std::size_t property)
  {
    const std::size_t column = property < this->ColumnOf.size() ? this->ColumnOf[property] : none;
    return column == none ? nullptr : this->Row.data() + this->ColumnList[column].rowOffset;
  }
  // Appends the row as the tuple of `times` points or triangles. Returns false if repeated rows
  // would take more than mostRepeated bytes in all: this stops a polygon with many corners in a
  // small file from filling the memory.
  bool Append(std::size_t times);
  // Makes room for `count` tuples of array k; returns a pointer to the first.
  std::uint8_t* Extend(std::size_t array, std::size_t count);
  // A pointer to the first of the last `count` tuples of array k.
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
  std::vector<std::size_t> Sizes;    // bytes of one tuple
  std::vector<std::uint8_t> Row;
  std::span<Attribute> Attributes;
  std::uint64_t MostRepeated = 0;
  std::uint64_t Repeated = 0;
};

}
