// SPDX-License-Identifier: BSD-3-Clause
// Loads the attributes of one block: its points' and triangles' tuples in files become arrays of
// its mesh.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/TreeBlock.h"

#include <span>

namespace kdstream
{

// Fills block.mesh.attributes with the arrays of `attributes`, in that order, in the block's own
// numbering: a tuple for each vertex, ghosts included, and for each triangle. attributes: point
// arrays first (SpilledMesh). pointTuples: the bytes of all point arrays' tuples by rank
// (SortTuplesByRank); cellTuples: those of all cell arrays by number of triangle (SpilledMesh). A
// file without arrays may be closed. Elements near each other are read together, in blocks of up to
// 1 MiB, and nothing is read twice. O(v log v + t) and their bytes; memory: the arrays, 8 bytes an
// element and a block. Errors: InputOutput.
Status LoadBlockTuples(std::span<const AttributeInfo> attributes, const SpillFile& pointTuples,
  const SpillFile& cellTuples, TreeBlock& block);

}
