// SPDX-License-Identifier: BSD-3-Clause
// Step "cut" out of core: passes one part of the mesh after the other to the cutter, each as if it
// were a whole mesh (core's PieceCutter cuts it). For the builders out of core and on ranks.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"

#include <functional>
#include <span>

namespace kdstream
{

// Receives one part of a resolution, as PieceCutter takes it. PieceCutter(tree, mesh, resolution,
// execution, part) cuts the same pieces, bit for bit, as from the whole mesh. tree and mesh are
// valid until the visit returns; mesh is empty unless the resolution is the original.
using PartVisit = std::function<Status(
  const VertexTree& tree, const Mesh& mesh, Resolution resolution, const ModelPart& part)>;

// Passes all parts to `visit`, on the calling thread: levels 0 … L, then the original. The parts of
// a resolution ascend, and every piece is in one part. A level above those in files is one part. A
// level in files has one part for each block of its file, and the original one for each block of
// the mesh. Each level is read once (ghosts once for each block that has them), the mesh once.
//
// Memory: CoarseTree, and one part at a time:
// - a level above the files, whole, or a block of a level in files: about 130 bytes a cluster and
//   40 a triangle while it is put in order;
// - a block of the mesh: as MeshBlocks::Load, and 24 bytes a vertex;
// - attributes;
// - the ancestors of ghosts, or of the clusters of a level from R to S: about 8 bytes for each and
//   level, less where they are near each other.
//
// group: each process gets the parts of its own blocks; the first process also gets those of the
// levels up to S. finished: called after the last part of each resolution, in every process.
// Errors: InputOutput; Damaged (NumberExternally); those of `visit`. REQUIRES: numbers of these
// levels; blocks of a level finer than S are at most as deep as its pieces (PieceDepth).
Status ForEachPart(const MeshBlocks& mesh, const ExternalLevels& levels,
  const ExternalNumbers& numbers, const PartVisit& visit, const Execution& execution = {},
  BlockGroup* group = nullptr, const std::function<Status(Resolution)>& finished = {});

// The same for partitions of any size without levels (OctreePartitions.h). There are only the parts
// of the original, one for each block of the mesh. Vertices are numbered by rank. partitionBegin:
// the first rank of each partition, and the end. REQUIRES: each block, by mesh.begin, consists of
// whole partitions.
Status ForEachPartOfPartitions(const MeshBlocks& mesh, std::span<const VertexId> partitionBegin,
  const PartVisit& visit, const Execution& execution = {});

}
