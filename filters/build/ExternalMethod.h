// SPDX-License-Identifier: BSD-3-Clause
// What a partition method does in a build out of core: the tree, the blocks, and the phases after
// "faces". Only for the builder and the methods (PartitionMethod.h).
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
  const char* name; // in the build folder
  const char* step; // as progress calls it
  Status (*make)(ExternalBuildState&);
};

struct ExternalPartitions
{
  TreeDepths depths;
  std::vector<Box> boxes; // of nodes 1 … 2^(P+1) - 1; those without a partition are empty
  // Rank of the first vertex of each partition, and the end; empty: cells of a k-d tree.
  std::vector<VertexId> begin;
  SpillFile records; // PointRecord<Scalar>, partition by partition, ids ascending inside each
  std::uint64_t recordsRead = 0; // all passes together
};

// Content for the store, from the mesh that LoadParts has loaded.
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
  // Whether partitions of such a mesh fit the memory, before they are made: CheckPartitionMemory.
  virtual Status CheckPartitions(const BlockedSize&, const BuildOptions&) const { return {}; }
  // Orders the vertices by partitions. records: ids ascending; consumed.
  virtual Result<ExternalPartitions> Partition(
    ExternalBuildState& build, const MeshFacts& facts, SpillFile& records) const = 0;
  // Fills in the blocks of a mesh that has all else but triangles and arrays.
  virtual Status PlanBlocks(
    ExternalBuildState& build, const MeshFacts& facts, MeshBlocks& mesh) const = 0;
  virtual std::vector<BuildPhase> PhasesAfterFaces() const = 0;
  // Loads what all phases have left; facts and mesh must outlive the result.
  virtual Result<StoreParts> LoadParts(
    ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh) const = 0;
};

}
