// SPDX-License-Identifier: BSD-3-Clause
// What a partition method does in a build out of core: it makes the tree, the blocks, and the
// phases after "faces". Only for the builder and the methods (PartitionMethod.h).
#pragma once

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/pieces/ExternalPieces.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace kdstream
{

struct BuildPhase
{
  const char* name; // the name in the build folder
  const char* step; // the name in progress reports
  Status (*make)(ExternalBuildState&);
};

struct ExternalPartitions
{
  TreeDepths depths;
  std::vector<Box> boxes; // of nodes 1 … 2^(P+1) - 1; empty for nodes without a partition
  // The first rank of each partition, and the end. Empty: partitions are cells of a k-d tree.
  std::vector<VertexId> begin;
  SpillFile records; // PointRecord<Scalar>, partition by partition, ids ascending inside each
  std::uint64_t recordsRead = 0; // in all passes together
};

// The content of the store that is made from the mesh loaded by LoadParts.
struct StoreParts
{
  std::uint64_t inconsistentEdges = 0;
  std::vector<double> geometricErrors; // of the levels
  std::function<Status(const PartVisit&, const std::function<Status(Resolution)>& finished)>
    forEach;
};

class ExternalMethod
{
public:
  virtual ~ExternalMethod() = default;
  // Checks, before partitions are made, that those of a mesh of this size fit in memory:
  // CheckPartitionMemory.
  virtual Status CheckPartitions(const BlockedSize&, const BuildOptions&) const { return {}; }
  // Orders the vertices by partitions. records: with ascending ids; consumed.
  virtual Result<ExternalPartitions> Partition(
    ExternalBuildState& build, const MeshFacts& facts, SpillFile& records) const = 0;
  // Determines the blocks of `mesh`, which has everything else except triangles and arrays.
  virtual Status PlanBlocks(
    ExternalBuildState& build, const MeshFacts& facts, MeshBlocks& mesh) const = 0;
  virtual std::vector<BuildPhase> PhasesAfterFaces() const = 0;
  // Loads the results of all phases; facts and mesh must outlive the result.
  virtual Result<StoreParts> LoadParts(
    ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh) const = 0;
};

}
