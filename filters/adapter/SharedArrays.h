// SPDX-License-Identifier: BSD-3-Clause
// Finds, compares and joins the arrays that all parts of a mesh have.
#pragma once

#include <vtkAbstractArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkUnsignedCharArray.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// The point or cell data of one part. A part without tuples does not count.
struct PartData
{
  vtkDataSetAttributes* data;
  vtkIdType tuples;
};

struct TupleOfPart
{
  std::uint32_t part;
  vtkIdType tuple;
};

struct SharedArray
{
  std::vector<vtkAbstractArray*> ofPart; // null for parts that do not count
  std::vector<int> attributes;           // vtkDataSetAttributes::AttributeTypes for which it is
                                         // active in all parts
  bool Is(int attribute) const;
};

// The array vtkGhostType; null if there is none that can be used. It must be a vtkUnsignedCharArray
// with one value for each point or cell.
vtkUnsignedCharArray* FindGhosts(const PartData& part);

// The arrays that all parts have, in the order of the first part: with the same name, type and
// number of components, and with a tuple for each point or cell. vtkGhostType is not among them.
// All other arrays are listed in `leftOut`, each once: `point array "A": not all parts have it`. A
// vtkGhostType that cannot be used is listed too. kind: "point" or "cell". O(parts · arrays²).
std::vector<SharedArray> FindSharedArrays(
  std::span<const PartData> parts, const std::string& kind, std::vector<std::string>& leftOut);

// The active global ids; null if there are none.
const SharedArray* FindGlobalIds(std::span<const SharedArray> arrays);
// The id of a tuple, exact even beyond 2^53.
std::int64_t IdOf(const SharedArray& ids, TupleOfPart tuple);

// Removes the arrays that FindSharedArrays lists as unusable: those of a wrong length, and a
// vtkGhostType that cannot be used.
void RemoveUnusableArrays(
  const PartData& part, const std::string& kind, std::vector<std::string>& leftOut);

// Hashes the values of numeric arrays, bit by bit.
std::uint64_t HashOfTuple(std::span<const SharedArray> arrays, TupleOfPart tuple);

// Adds the arrays, each with these tuples, to `output`. O(tuples).
void CopySharedArrays(std::span<const SharedArray> arrays, std::span<const TupleOfPart> tuples,
  vtkDataSetAttributes& output);

}
