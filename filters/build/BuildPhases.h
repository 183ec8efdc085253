// SPDX-License-Identifier: BSD-3-Clause
// The first phases of a build out of core, whatever cuts the mesh, and what they leave to later
// ones: MeshPhase.cxx, TreePhase.cxx, FacesPhase.cxx. For ExternalBuilder.cxx and the methods.
#pragma once

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"

namespace kdstream
{

// Finishes the phase "mesh": points and triangles with their arrays, as the file has them, welded.
// Memory: build.Memory. Errors: those of MeshReader and CheckClaimedPartitions; InvalidInput for an
// array without a name; InputOutput; Cancelled.
Status MakeMesh(ExternalBuildState& build);

// The facts about the mesh that the phase has found. Errors: Damaged; LimitExceeded where
// partitions cannot be held (CheckPartitionMemory).
Result<MeshFacts> LoadFacts(const ExternalBuildState& build);

// What decides how much memory its blocks take.
BlockedSize BlockedSizeOf(const MeshFacts& facts);

// Finishes the phase "tree": the vertices in the order of the leaves, and boxes. Takes the points
// of the phase "mesh". Errors: those of LoadFacts; InvalidInput for no vertices; those of the
// method's Partition.
Status MakeTree(ExternalBuildState& build);

// The mesh as the phases up to "tree" leave it, without triangles and arrays; fills in what `build`
// has by it. Errors: Damaged; LimitExceeded for a partition that cannot be held.
Status LoadMesh(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

// Finishes the phase "faces": triangles and arrays by blocks of the tree. Takes those of the phase
// "mesh". Errors: those of LoadMesh; LimitExceeded for a vertex with too many triangles
// (CheckHubs); InputOutput; Cancelled.
Status MakeFaces(ExternalBuildState& build);

// The mesh as all phases up to "faces" leave it. Errors: those of LoadMesh; LimitExceeded where its
// blocks were made with more memory.
Status LoadBlocks(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

}
