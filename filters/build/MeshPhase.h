// SPDX-License-Identifier: BSD-3-Clause
// The first phase of a build out of core: the file read in chunks, vertices welded, triangles
// renumbered. For ExternalBuilder.cxx and the phases after it.
#pragma once

#include "filters/build/BuildMemory.h"
#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"

namespace kdstream
{

// Does the phase "mesh": points and triangles with their arrays, as the file has them. Memory:
// build.Memory. Errors: those of MeshReader and CheckClaimedPartitions; InvalidInput for an array
// without a name; InputOutput; Cancelled.
Status MakeMesh(ExternalBuildState& build);

// Loads the results of the phase. Errors: Damaged; LimitExceeded if a partition does not fit the
// memory (CheckPartitionMemory).
Result<MeshFacts> LoadFacts(const ExternalBuildState& build);

// What decides how much memory its blocks take.
BlockedSize BlockedSizeOf(const MeshFacts& facts);

}
