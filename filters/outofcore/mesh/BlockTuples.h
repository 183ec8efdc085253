// SPDX-License-Identifier: BSD-3-Clause
// Loads the attributes of one block: reads the tuples of its points and triangles from files, and
// turns them into arrays of the block's mesh.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/TreeBlock.h"

#include <span>

namespace kdstream
{

// Fills block.mesh.attributes with the arrays of `attributes`, in that order and in the block's own
// numbering: one tuple for each vertex, ghosts included, and one for each triangle. attributes:
// point arrays first (SpilledMesh). pointTuples: the tuples of all point arrays by rank
// (SortTuplesByRank); cellTuples: those of all cell arrays by number of triangle (SpilledMesh). A
// file may be closed if there are no arrays for it. Elements near each other are read together, in
// blocks of up to 1 MiB, and nothing is read twice. O(v log v + t), and the bytes of the elements;
// memory: the arrays, 8 bytes an element and a block. Errors: InputOutput.
Status LoadBlockTuples(std::span<const AttributeInfo> attributes, const SpillFile& pointTuples,
  const SpillFile& cellTuples, TreeBlock& block);

}
