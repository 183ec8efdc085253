// SPDX-License-Identifier: BSD-3-Clause
// Turns the arrays of a vtkPolyData into core's attributes, and back. PolyDataMesh converts points
// and cells.
#pragma once

#include "filters/adapter/PolyDataMesh.h"
#include "filters/core/Attribute.h"
#include "filters/core/Result.h"

#include <vtkPolyData.h>

#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// The type of the VTK array that WriteAttributes makes for this attribute.
int VtkTypeOf(const AttributeInfo& attribute);

// The result of ReadAttributes.
struct PolyDataAttributes
{
  std::vector<Attribute> attributes; // point arrays first, each kind in the order of the input
  std::vector<std::string> skipped;  // e.g. `point array "Names": is not numeric`
};

// Copies point data to point attributes (a tuple for each point), and cell data to cell attributes
// (a tuple for each of elements.Triangles(): that of its cell).
//
// Arrays keep their names, except those that core knows by name (RoleOf, HoldsIds):
//   active normals of three floats or doubles          "Normals"
//   active texture coordinates of two components       "TCoords"
//   active scalars of three or four unsigned chars     "RGB", "RGBA" (these three of point data)
//   active global and pedigree ids, points and cells   "GlobalIds", "PedigreeIds"
// Types are kept bit for bit: vtkIdType, long and long long become int64 (or int32, where they
// are), char int8, bits uint8.
//
// Skipped and listed: arrays that are not numeric, have no name, have no or more than 255
// components, or have a wrong number of tuples; a second array with the same name; global ids of
// cells if some cells were split. Skipped and not listed: vtkGhostType, which has a meaning only
// within one pipeline. O(values). REQUIRES: `elements` were read from `input`.
PolyDataAttributes ReadAttributes(vtkPolyData& input, const PolyDataElements& elements);

// Adds the attributes to the arrays of `output`. Those with a role (RoleOf, HoldsIds) become active
// normals, scalars, texture coordinates, global and pedigree ids. int64 becomes vtkTypeInt64Array,
// or vtkIdTypeArray for ids. Errors: InvalidInput, naming the attribute, if its number of tuples
// differs from the number of points or cells; nothing is added then.
Status WriteAttributes(std::span<const Attribute> attributes, vtkPolyData& output);

}
