// SPDX-License-Identifier: BSD-3-Clause
// The first phases of a build out of core, which are the same for all partition methods, and
// functions that load their results: MeshPhase.cxx, TreePhase.cxx, FacesPhase.cxx. For
// ExternalBuilder.cxx and the methods.
#pragma once

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"

namespace kdstream
{

// Runs the phase "mesh": it leaves the points and triangles of the file with their arrays, welded.
// Memory: build.Memory. Errors: those of MeshReader and CheckClaimedPartitions; InvalidInput for an
// array without a name; InputOutput; Cancelled.
Status MakeMesh(ExternalBuildState& build);

// Loads the facts about the mesh that the phase "mesh" found. Errors: Damaged; LimitExceeded if
// partitions do not fit in memory (CheckPartitionMemory).
Result<MeshFacts> LoadFacts(const ExternalBuildState& build);

// What determines how much memory the blocks of this mesh take.
BlockedSize BlockedSizeOf(const MeshFacts& facts);

// Runs the phase "tree": it leaves the vertices in the order of the leaves, and boxes. Takes the
// points of the phase "mesh". Errors: those of LoadFacts; InvalidInput for no vertices; those of
// the method's Partition.
Status MakeTree(ExternalBuildState& build);

// Loads the mesh after the phase "tree", without triangles and arrays, and sets the members of
// `build` that depend on it. Errors: Damaged; LimitExceeded if a partition does not fit in memory.
Status LoadMesh(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

// Runs the phase "faces": it leaves triangles and arrays by blocks of the tree. Takes those of the
// phase "mesh". Errors: those of LoadMesh; LimitExceeded for a vertex with too many triangles
// (CheckHubs); InputOutput; Cancelled.
Status MakeFaces(ExternalBuildState& build);

// Loads the mesh after the phase "faces". Errors: those of LoadMesh; LimitExceeded if its blocks
// were made with more memory.
Status LoadBlocks(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

}
